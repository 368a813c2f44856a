#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/core/run_context.h>
#include <ecorche/domain/sizing_field.h>
#include <ecorche/domain/tet_files.h>

#include <string>
#include <vector>

namespace ecorche::domain {

/// What is to be filled with tets, twice: as it should be, and as it was before resampling.
struct FillTask {
  const TaggedSurface& walls;     ///< resampled, closed, facing outward
  const mesh::Positions& points;  ///< #P×3 vertices wanted inside [m]
  const TaggedSurface& carved;    ///< the same walls at their full density
  const std::vector<CutPlane>& cutPlanes;
  const std::vector<std::string>& boneNames;  ///< for errors
  const SizingField& sizing;
  double scale = 1.0;            ///< of all lengths in `sizing`
  double tolerance = 0.0;        ///< how far the boundary may end up from `carved` [m]
  double workerTimeout = 300.0;  ///< of each attempt [s]
};

struct Fill {
  TetAnswer tets;
  bool ofWalls = true;         ///< false: their boundary comes from `carved`
  std::string mesher;          ///< "TetGen" or "CGAL Mesh_3"
  bool fallback = false;       ///< TetGen refused
  std::string fallbackReason;  ///< its words
  Findings findings;
};

/// Fills a closed surface with tets, in a process of its own: TetGen, which keeps the walls as they
/// are; where it refuses them, TetGen on the walls at full density; last CGAL Mesh_3, which makes
/// them anew.
///
/// @errors  MeshingFailed (both refuse: with both reasons and, where walls cross, the place);
///          WorkerTimedOut (both take too long), WorkerMissing, OutOfMemory, Cancelled,
///          FileNotWritable (no room for temporary files)
[[nodiscard]] Result<Fill> fillWithTets(const FillTask& task, RunContext& run);

}  // namespace ecorche::domain
