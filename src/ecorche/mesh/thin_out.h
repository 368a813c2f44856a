#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <optional>

namespace ecorche::mesh {

struct ThinnedSurface {
  SurfaceMesh mesh;        ///< sound, `parts` dropped
  double deviation = 0.0;  ///< from the input and the input from it, at vertices and between [m]
};

/// The same surface with as few triangles as lie within a distance of it: edges collapse to where
/// the planes around them want them [Garland & Heckbert 1997]. What a sculpt of millions of
/// triangles says beyond that distance nobody can see in tets.
///
/// @param mesh     sound (see SurfaceCheck)
/// @param allowed  how far the result may lie from it [m]
/// @return  nothing where it cannot be kept that near, or nothing would be saved
/// @errors  Cancelled
[[nodiscard]] Result<std::optional<ThinnedSurface>> thinOut(const SurfaceMesh& mesh, double allowed,
                                                            RunContext& run);

}  // namespace ecorche::mesh
