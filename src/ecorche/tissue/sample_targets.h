#pragma once

#include <ecorche/tissue/tissue_fields.h>

#include <vector>

namespace ecorche::tissue {

/// What a sample's row asks its tissue for: the tissue value there.
/// @param tissue  the sample's own
[[nodiscard]] double sampleTarget(const CurveTissue& tissue, const CoreSample& sample);

/// What each sample's row asks its own tissue for: the tissue value there.
[[nodiscard]] std::vector<double> sampleTargets(const std::vector<CoreSample>& samples,
                                                const std::vector<CurveTissue>& tissues);

}  // namespace ecorche::tissue
