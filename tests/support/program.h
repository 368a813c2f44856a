#pragma once

#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "support/paths.h"

namespace ecorche::test {

/// What a finished program left behind.
struct Outcome {
  int exitCode = -1;
  std::string out;
  std::string err;
};

/// Runs the built command line through the shell: `ecorche info x.ecorche` is runEcorche("info
/// x.ecorche").
/// @param folder  where it runs; also gets the two captured streams
/// @param first   what the shell does before, ending in a semicolon: "ulimit -f 100;"
inline Outcome runEcorche(const std::string& arguments, const std::filesystem::path& folder,
                          const std::string& first = {}) {
  const auto slurp = [](const std::filesystem::path& file) {
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  };
  const std::filesystem::path out = folder / ".stdout", err = folder / ".stderr";
  const int status =
      std::system(fmt::format("cd '{}' && {} '{}/ecorche' {} >'{}' 2>'{}'", folder.string(), first,
                              ECORCHE_BIN_DIR, arguments, out.string(), err.string())
                      .c_str());
  Outcome outcome{WEXITSTATUS(status), slurp(out), slurp(err)};
  std::filesystem::remove(out);
  std::filesystem::remove(err);
  return outcome;
}

}  // namespace ecorche::test
