#pragma once

#include <ecorche/core/result.h>
#include <ecorche/engine/bench_drag.h>
#include <ecorche/model/project.h>

#include <CLI/CLI.hpp>
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
/// @param anisotropic  so many of the project's muscles get a spread of their own, from 0.1 to 10
/// @errors  those of loadProject, readFile and parseCount; FileSyntax
[[nodiscard]] Result<RecordedDrags> loadRecordedDrags(const std::string& project,
                                                      const std::string& script,
                                                      const std::string& tets, int anisotropic);

/// The option for it.
void addAnisotropic(CLI::App& bench, int& count);

[[nodiscard]] inline double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::ranges::max_element(values);
}

}  // namespace ecorche::cli
