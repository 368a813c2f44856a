#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/engine/bench_values.h>
#include <ecorche/model/project.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::engine {

/// A control point that a hand drags: where to, frame by frame.
struct DragScript {
  std::string name;
  std::string muscle;
  std::size_t curve = 0;
  std::size_t point = 0;
  int frames = 200;
  std::vector<mesh::Vector3> path;  ///< passed at an even pace [share of the skin's diagonal]

  /// Where the point is after so many frames, from where it was [share of the diagonal].
  [[nodiscard]] mesh::Vector3 offset(int frame) const;
};

/// How one drag went.
struct DragRun {
  std::string name;
  double begin = 0.0;  ///< what hovering takes [s]
  Times frame;         ///< new fields and owners wherever they changed
  Times again;         ///< the baseline on checked frames: trace, factor, solve all, owners
  std::vector<double>
      fieldError;  ///< per checked frame, all fields and vertices, over the largest value
  std::vector<double> ownerShare;    ///< of the vertices of muscles involved
  std::vector<double> changedShare;  ///< vertices written over, of all
  int unchecked = 0;  ///< frames to be checked where the curve leaves the skin: no field to compare
};

struct DragBench {
  std::int64_t tets = 0;
  std::int64_t freeVertices = 0;
  std::size_t tissues = 0;
  std::optional<double> simplicial;  ///< Eigen's SimplicialLDLT: factor and all fields once [s]
  std::vector<DragRun> runs;
};

/// Replays drags (tissue::ValueFields::moveCurves).
/// @param tets     size of the domain; unset: as the project says
/// @param checked  every so many frames are compared with a solve from scratch
/// @param simplicial  solve once with what users of libigl get, too
/// @errors  those of build; UnknownName for a muscle, curve or point that is not there; Cancelled
[[nodiscard]] Result<DragBench> benchDrag(const model::Project& project,
                                          std::optional<std::int64_t> tets,
                                          const std::vector<DragScript>& scripts, int checked,
                                          bool simplicial, RunContext& run);

}  // namespace ecorche::engine
