#pragma once

#include <ecorche/core/result.h>
#include <ecorche/domain/sizing_field.h>
#include <ecorche/domain/tagged_surface.h>

#include <string>
#include <string_view>
#include <vector>

namespace ecorche::domain {

/// What ecorche-worker is asked to fill with tets by TetGen.
struct TetRequest {
  TaggedSurface surface;   ///< closed, facing outward
  mesh::Positions points;  ///< #P×3 vertices wanted inside [m]
  mesh::Positions holes;   ///< #H×3 one point in every void [m]
  std::string switches;    ///< TetGen's
};

/// What ecorche-worker is asked to fill with tets by CGAL Mesh_3.
struct FillRequest {
  TaggedSurface surface;  ///< closed, facing outward
  std::vector<CutPlane> cutPlanes;
  SizingField sizing;
  double scale = 1.0;      ///< of all lengths in `sizing`
  double tolerance = 0.0;  ///< how far the boundary of the tets may lie from the surface [m]
};

/// What came of it: all tets, and the boundary triangles with the tags of the surface they lie on.
struct TetAnswer {
  mesh::Positions V;
  mesh::Tets T;
  mesh::Triangles F;
  std::vector<std::int32_t> tag;  ///< #F; -1: a face that no input face covers
};

[[nodiscard]] std::string encodeTetRequest(const TetRequest& request);
[[nodiscard]] std::string encodeFillRequest(const FillRequest& request);
[[nodiscard]] std::string encodeTetAnswer(const TetAnswer& answer);

/// They believe nothing of the bytes: the writer may have crashed half-way.
/// @errors  FileTruncated, FileSyntax for indices out of range
[[nodiscard]] Result<TetRequest> decodeTetRequest(std::string_view bytes);
[[nodiscard]] Result<FillRequest> decodeFillRequest(std::string_view bytes);
[[nodiscard]] Result<TetAnswer> decodeTetAnswer(std::string_view bytes);

}  // namespace ecorche::domain
