#pragma once

#include <ecorche/core/result.h>
#include <ecorche/engine/bench_drag.h>

#include <algorithm>
#include <string>
#include <vector>

namespace ecorche::cli {

/// {"drags": [{"name", "muscle", "curve", "point", "frames", "path_rel"}]}, curve and point from 1.
/// @errors  those of readFile; FileSyntax
[[nodiscard]] Result<std::vector<engine::DragScript>> loadDrags(const std::string& file);

[[nodiscard]] inline double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::ranges::max_element(values);
}

}  // namespace ecorche::cli
