#include <unistd.h>

#include <support/paths.h>
#include <catch2/catch.hpp>
#include <cstdlib>

namespace ecorche::test {

std::filesystem::path dataFolder() {
  if (const char* own = std::getenv("ECORCHE_DATA")) return own;
  return std::filesystem::path(ECORCHE_SOURCE_DIR).parent_path() / "shared" / "data";
}

bool haveData(const std::string& what) {
  const auto path = dataFolder() / what;
  if (std::filesystem::exists(path)) return true;
  WARN("SKIPPED: no " << path << "; this truth was not checked");
  return false;
}

TempFolder::TempFolder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "ecorche-test-XXXXXX").string();
  path_ = mkdtemp(pattern.data());
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace ecorche::test
