#pragma once

#include <ecorche/core/files.h>
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "support/paths.h"

namespace ecorche::test {

/// Debian's own interpreter: it is the one that has Debian's meshio and vtk.
inline constexpr const char* kPython = "/usr/bin/python3";

/// True where other people's readers are; says loudly that a test was skipped where they are not.
inline bool haveReaders() {
  const std::string command = std::string(kPython) + " -c 'import meshio, vtk' 2>/dev/null";
  if (std::system(command.c_str()) == 0) return true;
  WARN(
      "SKIPPED: python3-meshio or python3-vtk9 is not installed; other people's readers were not "
      "tried");
  return false;
}

/// What a Python program of the tests prints about a folder.
/// @param script  relative to tests/
/// @param words   further arguments
inline nlohmann::json pythonOn(const std::string& script, const std::filesystem::path& folder,
                               const std::string& words = {}) {
  const TempFolder temp;
  const auto seen = temp.path() / "seen.json";
  REQUIRE(std::system(fmt::format("{} '{}/tests/{}' '{}' {} >'{}'", kPython, ECORCHE_SOURCE_DIR,
                                  script, folder.string(), words, seen.string())
                          .c_str()) == 0);
  return nlohmann::json::parse(readFile(seen).value());
}

}  // namespace ecorche::test
