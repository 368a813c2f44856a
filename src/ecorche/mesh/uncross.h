#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <optional>

namespace ecorche::mesh {

/// The same surface without faces that cut one another: the faces around each crossing are
/// smoothed, or taken out and the gap filled, as far from the crossing as it takes and no farther.
///
/// @param mesh  sound (see SurfaceCheck)
/// @return  sound and free of self-intersections, `parts` dropped; nothing where that cannot be had
///          by local changes (a limb through another, an inner wall)
[[nodiscard]] std::optional<SurfaceMesh> uncross(const SurfaceMesh& mesh);

}  // namespace ecorche::mesh
