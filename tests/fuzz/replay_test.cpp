#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "fuzz/targets.h"

using namespace ecorche;
namespace fs = std::filesystem;

namespace {

const fs::path kCorpus = fs::path(ECORCHE_SOURCE_DIR) / "tests/fuzz/corpus";

std::string bytesOf(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// What a fuzzer does first: flip, cut, double and swap bytes.
std::string damaged(std::string bytes, std::mt19937& random) {
  for (unsigned blow = 0; blow <= random() % 4 && !bytes.empty(); ++blow) {
    const std::size_t at = random() % bytes.size();
    switch (random() % 5) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes.resize(at);
        break;
      case 2:
        bytes.insert(at, bytes.substr(at, random() % 20));
        break;
      case 3:
        bytes.erase(at, random() % 20);
        break;
      case 4:
        bytes[at] = "0123456789-/. \n"[random() % 15];
        break;
    }
  }
  return bytes;
}

std::vector<test::FuzzTarget> allTargets() {
  std::vector<test::FuzzTarget> all;
  for (const auto targets : {test::inputTargets(), test::ownTargets()})
    all.insert(all.end(), targets.begin(), targets.end());
  return all;
}

}  // namespace

TEST_CASE("every file of the corpus is read or refused") {
  for (const auto& target : allTargets()) {
    const fs::path folder = kCorpus / target.name;
    INFO(folder);
    REQUIRE_FALSE(fs::is_empty(folder));
    for (const auto& entry : fs::directory_iterator(folder)) {
      INFO(entry.path());
      CHECK_NOTHROW(target.run(bytesOf(entry.path())));
    }
    CHECK_NOTHROW(target.run(""));
  }
}

TEST_CASE("a thousand damaged copies of each are read or refused") {
  for (const auto& target : allTargets()) {
    std::set<fs::path> files;  // sorted, so that a seed means the same everywhere
    for (const auto& entry : fs::directory_iterator(kCorpus / target.name))
      files.insert(entry.path());
    std::mt19937 random(1);
    for (int trial = 0; trial < 1000; ++trial) {
      const auto& file = *std::next(files.begin(), std::ptrdiff_t(random() % files.size()));
      INFO(file << " trial " << trial);
      REQUIRE_NOTHROW(target.run(damaged(bytesOf(file), random)));
    }
  }
}
