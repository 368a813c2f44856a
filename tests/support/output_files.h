#pragma once

#include <ecorche/core/files.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace ecorche::test {

/// Names, relative to a folder, and bytes.
using Files = std::map<std::string, std::string>;

/// What differs from run to run in report.json, and nothing else does: times, memory, and how the
/// program was run. Beside it, whether a stage ran depends on what the cache held.
constexpr const char* kOfTheRun[] = {"stages", "total_seconds", "peak_memory_bytes",
                                     "peak_worker_memory_bytes", "machine"};

/// Every file of an output folder; report.json without kOfTheRun.
inline Files outputFiles(const std::filesystem::path& folder) {
  Files out;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    const std::string name = entry.path().lexically_relative(folder).string();
    std::string bytes = readFile(entry.path()).value();
    if (name == "report.json") {
      auto report = nlohmann::json::parse(bytes);
      for (const char* key : kOfTheRun) report.erase(key);
      bytes = report.dump(1);
    }
    out[name] = std::move(bytes);
  }
  return out;
}

}  // namespace ecorche::test
