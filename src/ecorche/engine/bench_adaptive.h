#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/engine/build.h>
#include <ecorche/model/project.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace ecorche::engine {

/// How far the interfaces of tissues on one domain are from those on a reference: areas in the
/// order of their distance, measured both ways and taken together [m].
struct InterfaceError {
  double mean = 0.0;
  double rms = 0.0;
  double p95 = 0.0;
};

struct AdaptiveCase {
  Sizing sizing = Sizing::None;
  std::int64_t tets = 0;
  std::int64_t vertices = 0;
  InterfaceError error;
  /// Tets that a uniform domain takes for the same mean error, between the uniform cases by a power
  /// law, over those of this one. Unset: of a uniform one, or worse than the coarsest.
  std::optional<double> saved;
  bool savesMore = false;  ///< it is better than the finest uniform one, which is what was taken
};

struct AdaptiveBench {
  std::int64_t referenceTets = 0;
  std::vector<AdaptiveCase>
      cases;  ///< uniform ones, around curves, around muscles; each coarse to fine
};

/// What small tets around muscles save, against domains that do not know of any muscle: interfaces
/// between two tissues, without walls, are compared with those of a fine domain.
/// @param tets       sizes of each kind, two or more
/// @param reference  size of the fine domain, sized by muscles
/// @errors  those of build; Cancelled
[[nodiscard]] Result<AdaptiveBench> benchAdaptive(const model::Project& project,
                                                  std::vector<std::int64_t> tets,
                                                  std::int64_t reference, RunContext& run);

}  // namespace ecorche::engine
