#pragma once

#include <ecorche/core/result.h>
#include <ecorche/engine/bench_drag.h>
#include <ecorche/model/project.h>

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::cli {

/// What benches of drags are given.
struct RecordedDrags {
  model::Project project;
  std::vector<engine::DragScript> scripts;
  std::optional<std::int64_t> tets;  ///< instead of the project's
};
/// @param script  {"drags": [{"name", "muscle", "curve", "point", "frames", "path_rel"}]}, curve
/// and point from 1
/// @param tets    a count; empty: none
/// @errors  those of loadProject, readFile and parseCount; FileSyntax
[[nodiscard]] Result<RecordedDrags> loadRecordedDrags(const std::string& project,
                                                      const std::string& script,
                                                      const std::string& tets);

[[nodiscard]] inline double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::ranges::max_element(values);
}

}  // namespace ecorche::cli
