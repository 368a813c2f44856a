#pragma once

#include <ecorche/tissue/tissue_fields.h>

namespace ecorche::tissue {

struct SolvedTissues {
  CoreSamples cores;
  TissueFields fields;
};

/// Curves traced through the domain and fields solved for them, in one go.
/// @errors  those of traceCurves and solveTissueFields
[[nodiscard]] Result<SolvedTissues> solveTissues(const domain::Domain& domain,
                                                 const std::vector<CurveTissue>& tissues,
                                                 const TissueOptions& options, RunContext& run);

}  // namespace ecorche::tissue
