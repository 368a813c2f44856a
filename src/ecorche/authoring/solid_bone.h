#pragma once

#include <ecorche/authoring/snap.h>
#include <ecorche/core/finding.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>

#include <string>

namespace ecorche::authoring {

/// How far a wrap may stray where curves are to keep out of bones, of the body's diagonal: less
/// than they keep clear of them.
inline constexpr double kSolidRel = 0.002;

/// A bone with an inside, whatever its mesh is like: closed as it is; else repaired as a domain
/// repairs it; else, as in a domain, inside is what an alpha wrap encloses. Ends still sit on the
/// surface as given.
/// @param wrapTolerance  how far a wrap may stray; gaps narrower than this are closed [m]
/// @param findings       gets a note where a wrap was needed
/// @errors  Cancelled; a mesh that nothing can be done about has no solid
[[nodiscard]] Result<BoneSurface> solidBone(std::string name, const mesh::SurfaceMesh& mesh,
                                            double wrapTolerance, Findings& findings,
                                            RunContext& run);

}  // namespace ecorche::authoring
