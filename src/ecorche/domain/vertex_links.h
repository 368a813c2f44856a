#pragma once

#include <ecorche/mesh/tet_mesh.h>

#include <optional>

namespace ecorche::domain {

/// A vertex whose tets are no ball and no half ball: its link is neither a sphere nor a disc. The
/// domain is a manifold where there is none.
[[nodiscard]] std::optional<Eigen::Index> firstSingularVertex(
    const mesh::TetMesh& mesh, const mesh::TetNeighbours& neighbours);

}  // namespace ecorche::domain
