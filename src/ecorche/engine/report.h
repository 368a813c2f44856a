#pragma once

#include <ecorche/engine/build.h>
#include <ecorche/exchange/output_folder.h>
#include <ecorche/exchange/report.h>

namespace ecorche::engine {

/// What report.json says about a build: figures, checks on what is in memory, repairs, times. The
/// checks on the written files are exchange::checkOutput's.
[[nodiscard]] exchange::Report makeReport(const model::Project& project, const Build& build,
                                          const exchange::WrittenOutput& written,
                                          const RunContext& run);

/// Share of each tissue's curves that runs through tets of its own, by length; what lies in bone or
/// beyond the skin runs through none. Entry i of tissue id i + 2.
[[nodiscard]] std::vector<double> curveSharesInside(const Build& build);

}  // namespace ecorche::engine
