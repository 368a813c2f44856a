#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/domain/tagged_surface.h>

#include <vector>

namespace ecorche::domain {

struct Hole;

/// One closed surface around meshes in any state, by an alpha wrap [Portaneri et al. 2022].
///
/// Gaps and dents narrower than about `tolerance` are bridged; elsewhere the wrap lies a third of
/// it outside. Each face takes the tag of the hole that is closest to its centroid.
/// @errors  MeshWithoutFaces where there is nothing to wrap, Cancelled
[[nodiscard]] Result<TaggedSurface> wrap(const std::vector<const Hole*>& holes, double tolerance,
                                         RunContext& run);

}  // namespace ecorche::domain
