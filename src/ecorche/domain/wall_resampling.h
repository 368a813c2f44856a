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
/// Where walls are near to each other from the start no step may make faces cross. Where they come
/// to cross elsewhere it is done again with the places watched. Where points of the old surface
/// between those that resampling carries along are lost, it is done again with half the length and
/// a third of the slack, and so on.
/// @errors  those of resample
[[nodiscard]] Result<WallResampling> resampleWalls(const TaggedSurface& surface,
                                                   const std::vector<CutPlane>& cutPlanes,
                                                   const SizingField& sizing, double scale,
                                                   double tolerance, RunContext& run);

}  // namespace ecorche::domain
