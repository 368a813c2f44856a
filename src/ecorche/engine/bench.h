#pragma once

#include <ecorche/engine/build.h>
#include <ecorche/tissue/resolution.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace ecorche::engine {

/// The same project on domains of several sizes, with well weights and with the paper's rows.
struct ResolutionBench {
  std::vector<tissue::CurveTissue> tissues;   ///< entry i has tissue id i + 2
  std::vector<tissue::ResolutionCase> cases;  ///< in the order asked for
  tissue::VolumeChange ours;
  tissue::VolumeChange paper;
};

/// "The same shape at every resolution", measured: tissue volumes from the fields themselves,
/// without the envelope's clamping. Domains come from the cache where they are in it.
/// @param tets  sizes to aim at; two or more
/// @errors  those of build; Cancelled
[[nodiscard]] Result<ResolutionBench> benchResolution(const model::Project& project,
                                                      const std::vector<std::int64_t>& tets,
                                                      RunContext& run);

/// A domain to preview in against the build's: two cases, in that order, measured as above.
/// @param preview  tets of the one
/// @param sizing   of the one: curves as they stand, or none
/// @param tets     of the other; unset: as the project says
/// @errors  those of build; Cancelled
[[nodiscard]] Result<ResolutionBench> benchPreview(const model::Project& project,
                                                   std::int64_t preview, Sizing sizing,
                                                   std::optional<std::int64_t> tets,
                                                   RunContext& run);

/// What becomes of volume shares when everything of a project, meshes and curves and radii, is
/// multiplied by a factor.
struct ScaleCase {
  double factor = 1.0;
  std::int64_t tets = 0;
  bool sameTets = false;  ///< the same connectivity as at factor 1
  /// Largest difference of any tissue's share of the domain's volume [unitless].
  double shareChange = 0.0;
  double totalChange = 0.0;    ///< of the muscles' volume together, relative [unitless]
  double largestChange = 0.0;  ///< of any muscle above 5 cm³ at factor 1, relative [unitless]
  std::size_t tissue = 0;      ///< which one
};

/// @param tets  size of the domain; unset: as the project says
/// @return  one case per factor, each against factor 1
/// @errors  those of build; Cancelled
[[nodiscard]] Result<std::vector<ScaleCase>> benchScale(const model::Project& project,
                                                        const std::vector<double>& factors,
                                                        std::optional<std::int64_t> tets,
                                                        RunContext& run);

}  // namespace ecorche::engine
