#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/mesh/tet_mesh.h>

#include <vector>

namespace ecorche::domain {

struct SmoothingResult {
  std::int64_t before = 0;  ///< tets with a dihedral angle under the limit
  std::int64_t after = 0;
  std::int64_t moved = 0;  ///< vertices
};

/// Moves inner vertices of slivers so that the worst dihedral angle around them grows [Freitag &
/// Ollivier-Gooch 1997, by search instead of linear programming]. Slivers make cotangent weights
/// huge and negative; the boundary stays.
///
/// @param fixed     #V 1: may not move
/// @param limitDeg  tets below this are looked at
SmoothingResult smoothSlivers(mesh::TetMesh& mesh, const std::vector<std::uint8_t>& fixed,
                              double limitDeg, RunContext& run);

}  // namespace ecorche::domain
