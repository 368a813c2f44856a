#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/domain/sizing_field.h>
#include <ecorche/domain/tagged_surface.h>

namespace ecorche::domain {

/// Where resampling had to be stricter than asked, and how it went.
struct WallResampling {
  TaggedSurface walls;
  int rounds = 1;  ///< how often the whole was resampled
  std::int64_t crossings =
      0;  ///< pairs of faces that cross in the end; 0 unless the rounds ran out
};

/// Resamples the carved surface to scale · sizing so that it lies within the tolerance both ways
/// and nowhere crosses itself.
///
/// What resampling does not watch is seen only afterwards: walls of a narrow gap that cross once
/// both are coarse, and points of the old surface between those that it carries along. Around such
/// places it is done again with half the length and a third of the slack, and so on.
/// @errors  those of resample
[[nodiscard]] Result<WallResampling> resampleWalls(const TaggedSurface& surface,
                                                   const std::vector<CutPlane>& cutPlanes,
                                                   const SizingField& sizing, double scale,
                                                   double tolerance, RunContext& run);

}  // namespace ecorche::domain
