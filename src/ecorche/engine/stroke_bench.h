#pragma once

#include <ecorche/authoring/stroke_depth.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/engine/stroke_atlas.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ecorche::engine {

/// A curve against the middle of the muscle that it is meant for.
struct CurveFit {
  double distance = 0.0;  ///< of the curve to the centreline, mean along the curve [m]
  double back = 0.0;      ///< of the centreline to the curve, likewise [m]
  double farthest = 0.0;  ///< of the curve to the centreline [m]
  bool leaves = false;    ///< goes through skin or bone (authoring::firstLeaving)
  std::size_t points = 0;
};

/// One muscle drawn from one side.
struct StrokeCase {
  std::string muscle;
  std::string from, to;  ///< bones
  std::string view;      ///< "lateral", "cranial-lateral" …
  int hidden = 0;        ///< ends that lie on the far side of their own bone from here
  double length = 0.0;   ///< of the centreline [m]
  CurveFit paper;        ///< depth linear, four points [ABLSJ21 §3.2]
  CurveFit bent;         ///< the same, bent out of bones and skin
  CurveFit ours;         ///< authoring::strokeInFlesh, then as before
  double seconds = 0.0;  ///< from the stroke to our control points
};

/// Which muscles are drawn.
enum class StrokeSet {
  Measured,  ///< sixty with one origin and one insertion
  Others     ///< what is left, and every head of those with several: habits are found with these
};

struct StrokeBenchOptions {
  StrokeSet set = StrokeSet::Measured;
  std::size_t muscles = 60;
  std::uint64_t seed = 1;  ///< of the hand
  /// Lateral and turned by 45° to the front and to the back for all, instead of the three sides
  /// from which both ends are seen.
  bool fixedViews = false;
  authoring::DepthHabits habits;
};

struct StrokeBench {
  std::vector<StrokeCase> cases;  ///< three for each muscle
};

/// How near first curves come to real muscles that somebody draws from three sides, the paper's
/// depth beside (docs/algorithms/first_guess.md).
/// @errors  ValueOutOfRange (fewer muscles than asked for), Cancelled
[[nodiscard]] Result<StrokeBench> benchStrokes(const StrokeAtlas& atlas,
                                               const StrokeBenchOptions& options, RunContext& run);

}  // namespace ecorche::engine
