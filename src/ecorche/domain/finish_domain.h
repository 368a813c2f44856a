#pragma once

#include <ecorche/domain/build_domain.h>
#include <ecorche/domain/tet_files.h>

namespace ecorche::domain {

/// Turns the mesher's answer into a Domain and proves it: positive tets, every boundary face
/// tagged, a manifold whose volume is that of the walls, specks dropped, every component with skin.
///
/// @param walls  the surface that was filled
/// @param names  boneNames, cutPlaneNames, skinDiagonal are taken from it
/// @errors MeshingFailed (the answer is no domain), ComponentWithoutSkin, Cancelled
[[nodiscard]] Result<Domain> finishDomain(TetAnswer answer, const TaggedSurface& walls,
                                          Domain names, DomainReport& report, RunContext& run);

}  // namespace ecorche::domain
