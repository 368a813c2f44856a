#pragma once

#include <ecorche/mesh/types.h>

#include <limits>
#include <string>
#include <vector>

namespace ecorche::mesh {

/// A named run of faces: an OBJ group, a glTF node, a TetGen region.
struct Part {
  std::string name;
  std::int32_t firstFace = 0;
  std::int32_t faceCount = 0;
};

/// Triangles over shared vertices; nothing is promised beyond valid indices (surface_check.h tells
/// the rest).
struct SurfaceMesh {
  std::string name;
  Positions V;              ///< #V×3 [m]
  Triangles F;              ///< #F×3, counter-clockwise from outside where the mesh is oriented
  std::vector<Part> parts;  ///< in face order, covering all faces; empty: one unnamed part

  [[nodiscard]] bool empty() const { return F.rows() == 0; }
};

/// Axis-aligned box; empty() until the first point.
struct Box {
  Vector3 lo = Vector3::Constant(std::numeric_limits<double>::infinity());
  Vector3 hi = Vector3::Constant(-std::numeric_limits<double>::infinity());

  void add(const Vector3& p) {
    lo = lo.cwiseMin(p);
    hi = hi.cwiseMax(p);
  }
  void add(const Box& b) {
    lo = lo.cwiseMin(b.lo);
    hi = hi.cwiseMax(b.hi);
  }
  [[nodiscard]] bool empty() const { return !(lo.x() <= hi.x()); }
  [[nodiscard]] Vector3 centre() const { return 0.5 * (lo + hi); }
  [[nodiscard]] double diagonal() const { return empty() ? 0.0 : (hi - lo).norm(); }
};

[[nodiscard]] Box boundingBox(const Positions& V);
/// Box of the vertices that faces use.
[[nodiscard]] Box boundingBox(const SurfaceMesh& mesh);

/// Signed volume enclosed [m³]: positive where triangles face outward. Meaningful for closed
/// meshes.
[[nodiscard]] double signedVolume(const Positions& V, const Triangles& F);
[[nodiscard]] double surfaceArea(const Positions& V, const Triangles& F);

/// Unit normals at vertices, faces weighted by their angle there [Thürmer & Wüthrich 1998]. Unused
/// vertices: zero.
[[nodiscard]] Directions vertexNormals(const Positions& V, const Triangles& F);

/// The same surface without vertices that no face uses; order of the rest is kept.
[[nodiscard]] SurfaceMesh compacted(const SurfaceMesh& mesh);

/// Faces of one part, compacted, named after it.
[[nodiscard]] SurfaceMesh partOf(const SurfaceMesh& mesh, std::size_t part);

/// All faces in one mesh, one part each (named after the mesh), vertices not merged.
[[nodiscard]] SurfaceMesh joined(const std::vector<SurfaceMesh>& meshes, std::string name);

}  // namespace ecorche::mesh
