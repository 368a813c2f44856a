#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

#include <vector>

namespace ecorche::authoring {

/// How far a skin made for bones lies from them unless told otherwise, as a share of the bones'
/// common diagonal: about as thick as the flesh on a limb.
inline constexpr double kSkinOffsetRel = 0.03;

/// A skin for bones that come without one: a closed surface in one piece, this far outside all of
/// them, bridging what lies between. It is a first skin, to be sculpted, and no reconstruction.
///
/// @param bones     in any state; open or crossing ones do no harm
/// @param distance  from the bones [m, > 0]
/// @errors  MeshWithoutFaces, NonFiniteVertex, Cancelled
[[nodiscard]] Result<mesh::SurfaceMesh> offsetSkin(const std::vector<mesh::SurfaceMesh>& bones,
                                                   double distance, RunContext& run);

}  // namespace ecorche::authoring
