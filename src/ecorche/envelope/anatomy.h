#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/domain/domain.h>
#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/mesh/tet_mesh.h>

#include <array>
#include <string>
#include <vector>

namespace ecorche::envelope {

/// The domain subdivided by the largest field: every tet belongs to one tissue, faces are shared
/// exactly. Vertices 0 … #V(domain)−1 are the domain's own, in its order; new ones follow.
struct Anatomy {
  mesh::TetMesh mesh;
  mesh::TetNeighbours neighbours;       ///< #T×4
  std::vector<TissueId> label;          ///< #T
  std::vector<std::int32_t> parentTet;  ///< #T the domain's tet that each came from

  /// New vertex v = #V(domain) + k lies at Σ weight[k][c] · V[corner[k][c]] of the domain; unused
  /// corners are -1.
  struct Origin {
    std::array<std::int32_t, 4> corner{-1, -1, -1, -1};
    std::array<double, 4> weight{0.0, 0.0, 0.0, 0.0};
  };
  std::vector<Origin> origin;  ///< #V − #V(domain)

  mesh::Triangles boundaryF;                     ///< of the whole domain, facing outward
  std::vector<std::int32_t> boundaryTet;         ///< #B
  std::vector<domain::BoundaryTag> boundaryTag;  ///< #B
};

}  // namespace ecorche::envelope
