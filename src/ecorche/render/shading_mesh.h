#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <cstdint>
#include <vector>

namespace ecorche::render {

struct NormalOptions {
  /// Edges whose faces turn by more than this stay sharp. 180: everything smooth [degrees].
  double creaseDeg = 60.0;
  /// Rounds of averaging with neighbours: hides the facets of a raw tet surface, moves no vertex.
  /// 0: as they are.
  int smoothing = 0;
};

/// A surface as the graphics card wants it: a vertex stands once for every smooth group of faces
/// around it, so that creases stay sharp and everything else is round.
struct ShadingMesh {
  std::vector<std::int32_t> vertex;  ///< #N the mesh's vertex each came from
  mesh::Directions normals;          ///< #N×3; zero only where all faces around have no area
  mesh::Triangles F;                 ///< #F×3 into the above, faces in the mesh's order
};

/// Normals of faces weighted by their angle at the vertex [Thürmer & Wüthrich 1998], over smooth
/// groups. Where winding changes across an edge the edge is a crease. Deterministic for any thread
/// count.
[[nodiscard]] ShadingMesh shadingMesh(const mesh::SurfaceMesh& mesh, const NormalOptions& options);

}  // namespace ecorche::render
