#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/domain/build_domain.h>
#include <ecorche/envelope/anatomy.h>
#include <ecorche/tissue/tissue.h>

#include <vector>

namespace ecorche::engine {

/// Edge lengths wanted where muscles meet each other, fat and bone: shares of how thick each muscle
/// is, 2 V / A, less where it tapers along its curve and where it borders on fat. So every muscle
/// gets about as many tets across, and the same share of it is lost or gained by interpolating
/// linearly (docs/algorithms/domain.md).
///
/// @param anatomy   a first idea of where the tissues are; its tets may be coarse
/// @param tissues   muscles and fillers of it; fillers want nothing for themselves
/// @param diagonal  of the uncut skin [m]
/// @return  one length per small cube of space that holds an interface, ordered by place; the last
/// bits of the fields do not show in it
[[nodiscard]] std::vector<domain::WantedLength> lengthsWhereTissuesMeet(
    const envelope::Anatomy& anatomy, const std::vector<tissue::CurveTissue>& tissues,
    double diagonal);

/// The same from nothing but the input: a coarse domain is built, filled with fields and cut.
///
/// @param input    with a first guess of its lengths
/// @param options  of the domain itself
/// @errors  those of domain::buildDomain, tissue::traceCurves, tissue::solveTissueFields and
/// envelope::buildAnatomy
[[nodiscard]] Result<std::vector<domain::WantedLength>> lengthsFromDraft(
    const domain::DomainInput& input, const domain::DomainOptions& options,
    const std::vector<tissue::CurveTissue>& tissues, const tissue::TissueOptions& how,
    RunContext& run);

}  // namespace ecorche::engine
