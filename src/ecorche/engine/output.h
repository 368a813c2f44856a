#pragma once

#include <ecorche/core/files.h>
#include <ecorche/engine/build.h>
#include <ecorche/exchange/output_folder.h>
#include <ecorche/exchange/report.h>

#include <filesystem>

namespace ecorche::engine {

struct OutputOptions {
  exchange::OutputFormats formats;
  bool preview = true;  ///< preview.png, where the machine can draw
};

/// Where a build is written to until it is whole. Only an empty folder and the output of an earlier
/// build are replaced.
/// @errors FileNotWritable
[[nodiscard]] Result<StagedFolder> stageOutput(const std::filesystem::path& folder);

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
