#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace ecorche::test {

/// Sets a variable of the environment for one scope.
class Environment {
 public:
  Environment(const char* name, const std::string& value) : name_(name) {
    if (const char* old = std::getenv(name)) old_ = old;
    setenv(name, value.c_str(), 1);
  }
  ~Environment() { old_.empty() ? unsetenv(name_) : setenv(name_, old_.c_str(), 1); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  const char* name_;
  std::string old_;
};

/// A shell script to stand in for ecorche-worker, for ECORCHE_WORKER.
inline std::filesystem::path pretendWorker(const std::filesystem::path& folder,
                                           const std::string& script) {
  const std::filesystem::path file = folder / "worker";
  std::ofstream(file) << "#!/bin/sh\n" << script << "\n";
  std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  return file;
}

}  // namespace ecorche::test
