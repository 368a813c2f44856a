#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <optional>

namespace ecorche::mesh {

/// What the closed pieces of a surface enclose together: their union, exact. Unlike outerHull it
/// takes pieces whose faces lie upon those of others.
///
/// @param mesh  sound (see SurfaceCheck), all its pieces outward
/// @return  sound and free of self-intersections, `parts` dropped; nothing where a piece is beyond
///          outerHull or the exact way is barred (pieces that touch in an edge or a vertex)
[[nodiscard]] std::optional<SurfaceMesh> pieceUnion(const SurfaceMesh& mesh, RunContext& run);

}  // namespace ecorche::mesh
