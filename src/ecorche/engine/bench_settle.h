#pragma once

#include <ecorche/engine/bench_drag.h>

namespace ecorche::engine {

/// How settling after one drag went, let go at several places of its way.
struct SettleRun {
  std::string name;
  Times settle;     ///< trace, solve for what is left, owners: ready to be dragged again
  Times again;      ///< the baseline: trace, factor (CHOLMOD), solve all, owners
  Times abandoned;  ///< from a cancel in the midst of one until it has ended
  Times meanwhile;  ///< frames of the drag that cancelled it, until then
  std::vector<double> fieldError;  ///< settled against the baseline, over the largest value
  std::vector<double> factored;    ///< share of the factor that was made anew
  std::vector<int> passes;         ///< of refinement
  std::int64_t ownersOff = 0;      ///< vertices, of all places together
  int unchecked = 0;               ///< places where the curve leaves the skin
};

struct SettleBench {
  std::int64_t tets = 0;
  std::int64_t freeVertices = 0;
  std::size_t tissues = 0;
  double first = 0.0;     ///< solved for the first time, nothing to go on from [s]
  double analysis = 0.0;  ///< once per domain, not part of any other time [s]
  std::vector<SettleRun> runs;
};

/// Lets go of recorded drags (tissue::Settling) at `places` places of each, one after the other:
/// each goes on from the one before.
/// @param tets  size of the domain; unset: as the project says
/// @errors  those of build; UnknownName for a muscle, curve or point that is not there; Cancelled
[[nodiscard]] Result<SettleBench> benchSettle(const model::Project& project,
                                              std::optional<std::int64_t> tets,
                                              const std::vector<DragScript>& scripts, int places,
                                              RunContext& run);

}  // namespace ecorche::engine
