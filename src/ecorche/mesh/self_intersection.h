#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace ecorche::mesh {

/// Pairs of faces that meet elsewhere than in the vertices and edges they share, each pair once,
/// ascending. Exact. Faces over the same three vertices and faces without area are left out.
[[nodiscard]] std::vector<std::pair<std::int32_t, std::int32_t>> selfIntersections(
    const Positions& V, const Triangles& F);

}  // namespace ecorche::mesh
