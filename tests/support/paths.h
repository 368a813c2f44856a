#pragma once

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

namespace ecorche::test {

/// The real meshes beside the project, or what ECORCHE_DATA names.
inline std::filesystem::path dataFolder() {
  if (const char* own = std::getenv("ECORCHE_DATA")) return own;
  return std::filesystem::path(ECORCHE_SOURCE_DIR).parent_path() / "shared" / "data";
}

/// True where the real meshes are; says loudly that a test was skipped where they are not.
inline bool haveData(const std::string& what) {
  const auto path = dataFolder() / what;
  if (std::filesystem::exists(path)) return true;
  WARN("SKIPPED: no " << path << "; this truth was not checked");
  return false;
}

/// A fresh folder that is removed at the end of the test.
class TempFolder {
 public:
  TempFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "ecorche-test-XXXXXX").string();
    path_ = mkdtemp(pattern.data());
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace ecorche::test
