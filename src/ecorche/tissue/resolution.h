#pragma once

#include <ecorche/tissue/tissue_fields.h>

#include <vector>

namespace ecorche::tissue {

/// What the same muscles come to on one domain, with well weights and with the paper's rows beside
/// them.
struct ResolutionCase {
  std::int64_t tets = 0;
  std::int64_t freeVertices = 0;
  std::vector<double> volume;       ///< by id − 1: fat first [m³]
  std::vector<double> volumePaper;  ///< the same with α = 5 [m³]
  double seconds = 0.0;             ///< tracing and solving with well weights
};

/// @errors  those of traceCurves and solveTissueFields
[[nodiscard]] Result<ResolutionCase> measureResolution(const domain::Domain& domain,
                                                       const std::vector<CurveTissue>& tissues,
                                                       const TissueOptions& options,
                                                       RunContext& run);

/// How far volumes spread over several cases: largest over smallest, minus 1 [unitless].
struct VolumeChange {
  double total = 0.0;      ///< of all muscles together (fillers not counted)
  double largest = 0.0;    ///< of any one muscle above the least volume in every case
  std::size_t tissue = 0;  ///< which one, in the list of tissues
};
/// @param paper        look at volumePaper instead
/// @param leastVolume  muscles below this do not count alone [m³]
[[nodiscard]] VolumeChange volumeChange(const std::vector<ResolutionCase>& cases,
                                        const std::vector<CurveTissue>& tissues, bool paper,
                                        double leastVolume = 5e-6);

/// Cross-sections of one straight muscle of constant value on a coarse domain against the same on a
/// finer one, along the middle two thirds of its curve.
struct Smoothness {
  double across = 0.0;     ///< tets across: mean diameter over mean edge along the curve
  double meanRatio = 0.0;  ///< of areas, coarse over fine
  double deviation = 0.0;  ///< standard deviation of that ratio over its mean
};
/// @param muscle  of one curve of two points
/// @errors  those of traceCurves and solveTissueFields
[[nodiscard]] Result<Smoothness> measureSmoothness(const domain::Domain& coarse,
                                                   const domain::Domain& fine,
                                                   const CurveTissue& muscle,
                                                   const TissueOptions& options, RunContext& run);

}  // namespace ecorche::tissue
