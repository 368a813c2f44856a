#pragma once

#include <ecorche/engine/build.h>
#include <ecorche/exchange/output_folder.h>
#include <ecorche/exchange/report.h>

#include <filesystem>

namespace ecorche::engine {

struct OutputOptions {
  exchange::OutputFormats formats;
  bool preview = true;  ///< preview.png, where the machine can draw
};

/// Writes a build's folder whole or not at all: files as exchange::writeOutput, report.json,
/// preview.png.
///
/// A machine that cannot draw gives a finding instead of a preview.
/// @return the report that was written
/// @errors FileNotWritable, Cancelled
[[nodiscard]] Result<exchange::Report> writeBuild(const model::Project& project, const Build& build,
                                                  const std::filesystem::path& folder,
                                                  const OutputOptions& options, RunContext& run);

}  // namespace ecorche::engine
