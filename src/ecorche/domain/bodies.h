#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/domain/carve.h>
#include <ecorche/domain/tagged_corefinement.h>

#include <string>
#include <vector>

namespace ecorche::domain {

/// One closed surface to take out of the skin: a hole, or several that were united.
struct Body {
  std::vector<const Hole*> holes;
  std::vector<const Hole*> wrapped;  ///< of them, those that a wrap stands for
  std::vector<const Hole*> grown;    ///< of them, those that were grown to overlap others
  TaggedMesh mesh;
};

/// How far a body is grown that touches others in no more than edges or vertices [m].
[[nodiscard]] constexpr double growth(double wrapTolerance) { return 0.02 * wrapTolerance; }

[[nodiscard]] std::string namesOf(const std::vector<const Hole*>& holes);

/// The hole as it is if it is fit for that, otherwise a wrap around it.
/// @errors  MeshNotRepairable, Cancelled
[[nodiscard]] Result<Body> bodyOf(const Hole& hole, double wrapTolerance, RunContext& run);

/// @errors  MeshNotRepairable where no wrap closes, Cancelled
[[nodiscard]] Result<Body> wrapBody(const std::vector<const Hole*>& holes, double wrapTolerance,
                                    RunContext& run);

/// Bodies of which no two touch: those that touched, overlapped or held one another are united,
/// exactly where that works, grown by a hair where they touch in no more than edges or vertices,
/// and by a wrap where neither works. A wrap that reaches a neighbour is united with that too.
/// @errors  MeshNotRepairable, Cancelled
[[nodiscard]] Result<std::vector<Body>> unitedBodies(std::vector<Body> bodies, double wrapTolerance,
                                                     RunContext& run);

}  // namespace ecorche::domain
