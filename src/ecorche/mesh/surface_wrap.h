#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

namespace ecorche::mesh {

/// One closed surface around triangles in any state, by an alpha wrap [Portaneri et al. 2022]: no
/// self-intersections, nothing of the input outside.
///
/// @param alpha   gaps, dents and bags narrower than about this are bridged [m, > 0]
/// @param offset  how far the wrap lies outside where the input is smooth [m, > 0]
/// @return  facing outward; triangles without area are not seen
/// @errors  MeshWithoutFaces (no triangle has an area), Cancelled
[[nodiscard]] Result<SurfaceMesh> wrapSurface(const SurfaceMesh& mesh, double alpha, double offset,
                                              RunContext& run);

}  // namespace ecorche::mesh
