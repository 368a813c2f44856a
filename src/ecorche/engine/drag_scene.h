#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/engine/bench_drag.h>
#include <ecorche/engine/clock.h>
#include <ecorche/model/project.h>
#include <ecorche/tissue/curve_drag.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/tissue_solver.h>

#include <memory>
#include <optional>
#include <vector>

namespace ecorche::engine {

/// A project's domain and curves, ready for recorded drags.
struct DragScene {
  std::shared_ptr<const domain::Domain> domain;
  std::vector<tissue::CurveTissue> tissues;
  tissue::TissueOptions how;
  std::shared_ptr<const tissue::TissueSolver> solver;  ///< of `domain`
  std::shared_ptr<const tissue::CurveWalker> walker;
  std::vector<tissue::CurveRef> curves;  ///< that each script drags

  /// Curves while a point is on its way.
  [[nodiscard]] mesh::Spline splineAt(const DragScript& script, tissue::CurveRef curve,
                                      int frame) const;
};

/// @errors  those of build; UnknownName for a muscle, curve or point that is not there
[[nodiscard]] Result<DragScene> prepareDragScene(const model::Project& project,
                                                 std::optional<std::int64_t> tets,
                                                 const std::vector<DragScript>& scripts,
                                                 RunContext& run);

}  // namespace ecorche::engine
