#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <optional>

namespace ecorche::mesh {

/// The skin of what a surface that cuts itself encloses: the boundary of all points around which it
/// winds at least once. Folds turned inside out and what lies within something else go; its
/// faces are faces of the input or pieces of them. Where two tips touch in a vertex, as at the end
/// of a fold, both are drawn back by a twentieth of their shortest edge.
///
/// @param mesh  sound (see SurfaceCheck), outward
/// @return  sound and free of self-intersections, `parts` dropped; nothing where the exact way is
///          barred (faces upon one another, parts that touch in an edge, patches between crossings
///          too small for doubles), and after a cancel
[[nodiscard]] std::optional<SurfaceMesh> outerHull(const SurfaceMesh& mesh, RunContext& run);

}  // namespace ecorche::mesh
