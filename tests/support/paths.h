#pragma once

#include <filesystem>
#include <string>

namespace ecorche::test {

/// The real meshes beside the project, or what ECORCHE_DATA names.
[[nodiscard]] std::filesystem::path dataFolder();

/// True where the real meshes are; says loudly that a test was skipped where they are not.
[[nodiscard]] bool haveData(const std::string& what);

/// A fresh folder that is removed at the end of the test.
class TempFolder {
 public:
  TempFolder();
  ~TempFolder();
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace ecorche::test
