#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/model/project.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace ecorche::engine {

/// Times of one kind of act.
struct Times {
  std::vector<double> seconds;  ///< one per act, in order
  [[nodiscard]] double quantile(double q) const;
};

/// How fast tissue values and fat answer, against solving again (tissue::ValueFields).
struct ValuesBench {
  std::int64_t tets = 0;
  std::int64_t freeVertices = 0;
  std::size_t tissues = 0;
  Times touch;              ///< the first edit of a muscle, owners at all vertices
  Times point;              ///< the first edit of each of its other control points, likewise
  Times whole;              ///< all of its values by one factor, likewise
  Times value;              ///< a value of a point that was edited before, likewise
  Times fat;                ///< fat, likewise
  Times again;              ///< the baseline: factor, solve all fields, owners; analysis reused
  double fieldError = 0.0;  ///< at the end, against a solve from scratch, over the largest value
  double ownerShare = 0.0;  ///< of vertices whose owner is another one
};

/// @param tets   size of the domain; unset: as the project says
/// @param edits  of values, spread over twelve muscles; a quarter as many of fat
/// @errors  those of build; Cancelled
[[nodiscard]] Result<ValuesBench> benchValues(const model::Project& project,
                                              std::optional<std::int64_t> tets, int edits,
                                              RunContext& run);

}  // namespace ecorche::engine
