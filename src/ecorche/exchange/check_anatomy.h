#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/exchange/report.h>

#include <filesystem>
#include <optional>
#include <vector>

namespace ecorche::exchange {

/// What the files of an output folder are worth.
struct CheckReport {
  std::vector<Check> checks;
  std::int64_t tets = 0;
  std::int64_t vertices = 0;
  /// Volume, area, components, tets of every tissue, from the files alone.
  std::vector<TissueFigures> tissues;

  [[nodiscard]] bool pass() const;
};

struct CheckOptions {
  /// Measure how far skin and bones lie from the input: most of the time that a small output takes.
  bool deviation = true;
};

/// Reads back a folder that `build` wrote and tests every promise on the files' geometry: nothing
/// comes from memory, nothing is believed but model.json (curves, planes, which file is which).
///
/// Checks, where their file exists: files-complete, formats-agree, tets-positive (exact),
/// faces-shared, faces-marked, boundary-closed, volumes-add-up (1e-9), labels-known, and per muscle
/// muscles-closed, muscles-manifold-edges, muscles-manifold-vertices, muscles-connected,
/// curves-inside (95 % of the length), surfaces-agree (1e-9, vertices to the bit); fibers-unit,
/// fibers-follow-curves (15°), fibers-origin-to-insertion, fibers-no-extrema (0.5 %);
/// skin-deviation, bone-deviation (both ways, 0.1 % of the diagonal); report-agrees.
/// docs/formats.md says what each of them means.
///
/// @errors what the readers say about a file that cannot be read; Cancelled. A check that fails is
/// no error here.
[[nodiscard]] Result<CheckReport> checkOutput(const std::filesystem::path& folder, RunContext& run,
                                              const CheckOptions& options = {});

/// One CheckFailed that lists the failed checks, what and where; nothing where all passed.
[[nodiscard]] std::optional<Error> failure(const CheckReport& report,
                                           const std::filesystem::path& folder);

/// JSON text: the checks and figures.
[[nodiscard]] std::string printCheckReport(const CheckReport& report);

}  // namespace ecorche::exchange
