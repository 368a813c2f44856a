#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/mesh/tet_mesh.h>
#include <ecorche/render/scene.h>

#include <array>
#include <map>
#include <vector>

namespace ecorche::render {

/// Where a plane cuts labelled tets.
struct TetSlice {
  mesh::SurfaceMesh
      mesh;  ///< the cut, facing against the plane's normal (towards what was taken away)
  std::vector<TissueId> label;  ///< #F tissue of every face
  /// Segments where two tissues meet, and where the domain ends (its second tissue is kNoTissue).
  struct Border {
    mesh::Vector3 from, to;
    TissueId one, other;  ///< one > other
  };
  std::vector<Border> borders;
  std::map<TissueId, double> area;  ///< [m²]
};

/// Cuts every tet that the plane passes through into a triangle or a quad.
///
/// Vertices on the plane count as kept, so that a plane through vertices gives the same cut as one
/// just beside them; neighbouring tets share their cut vertices, the mesh is conforming.
///
/// @param labels      #T
/// @param neighbours  #T×4, as mesh::tetAdjacency gives
[[nodiscard]] TetSlice sliceTets(const mesh::TetMesh& tets, const std::vector<TissueId>& labels,
                                 const mesh::TetNeighbours& neighbours, const ClipPlane& plane);

/// Where a plane cuts a closed surface: the inside, filled.
struct SurfaceSlice {
  mesh::SurfaceMesh
      mesh;  ///< facing against the plane's normal; T-junctions on lines across the cut
  std::vector<std::array<mesh::Vector3, 2>> outline;  ///< segments, one per cut face
  double area = 0.0;                                  ///< [m²]
};

/// Inside is what a line enters and has not left yet (even-odd), so that nested and touching
/// shells, and either orientation, are fine; where a surface is open, what remains unpaired is left
/// out.
[[nodiscard]] SurfaceSlice sliceSurface(const mesh::SurfaceMesh& surface, const ClipPlane& plane);

/// The scene with the cuts of its capped opaque items filled; as it is where nothing is clipped.
[[nodiscard]] Scene withCaps(const Scene& scene);

/// The slice as an item that the clip plane leaves alone, and its borders as thin dark lines.
/// @param colourOf  by tissue id; tissues beyond its end are grey
[[nodiscard]] SurfaceItem sliceItem(const TetSlice& slice, const std::vector<Rgba>& colourOf);
[[nodiscard]] LineItem sliceBorders(const TetSlice& slice, float widthPixels = 1.5f);

}  // namespace ecorche::render
