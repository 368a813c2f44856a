#pragma once

#include <ecorche/domain/build_domain.h>
#include <ecorche/domain/carve.h>

namespace ecorche::domain {

/// How far the domain's boundary and the input are apart, both ways, where the input is exposed.
///
/// Exposed is what carving left of a surface: inside the skin, outside every other hole, on the
/// kept side of all cut planes. Of a hole that was wrapped it is the part that sees no other face
/// of the holes straight ahead within the tolerance. Distances are taken at faceSamples.
///
/// @param carved     exact surface before resampling, and which holes were wrapped
/// @param tolerance  what was asked for [m]
/// @return  skin first, then holes that have faces in the domain, in input order
[[nodiscard]] std::vector<SurfaceDeviation> measureDeviations(const Domain& domain,
                                                              const Carved& carved,
                                                              const CarveInput& input,
                                                              double tolerance, RunContext& run);

}  // namespace ecorche::domain
