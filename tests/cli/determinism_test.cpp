// The same project gives the same bytes, whatever the threads, the run and the cache.

#include <catch2/catch.hpp>

#include "support/output_files.h"
#include "support/program.h"
#include "support/small_project.h"

using namespace ecorche;
using test::SmallProject;
namespace fs = std::filesystem;

namespace {

// Names and sizes of what differs, for the message
std::string difference(const test::Files& a, const test::Files& b) {
  std::string out;
  for (const auto& [name, bytes] : a) {
    const auto other = b.find(name);
    if (other == b.end()) {
      out += name + " is missing\n";
    } else if (other->second != bytes) {
      const auto at = std::ranges::mismatch(bytes, other->second).in1 - bytes.begin();
      const auto from = std::size_t(std::max<std::ptrdiff_t>(0, at - 60));
      out += fmt::format("{} differs at byte {} of {}\n", name, at, bytes.size());
      if (bytes.find('\0') == std::string::npos)
        out += bytes.substr(from, 120) + "\n--\n" + other->second.substr(from, 120) + "\n";
    }
  }
  return a.size() == b.size() ? out : out + "other files\n";
}

}  // namespace

TEST_CASE("build: the same bytes on one thread and two, from run to run, with and without cache") {
  const SmallProject p;
  const auto built = [&](const std::string& arguments) {
    const auto run = test::runEcorche("build limb.ecorche --quiet -o out " + arguments, p.folder(),
                                      fmt::format("ECORCHE_CACHE='{}'", p.at("cache").string()));
    INFO(run.err);
    REQUIRE(run.exitCode == 0);
    auto files = test::outputFiles(p.at("out"));
    fs::remove_all(p.at("out"));
    return files;
  };
  const auto first = built("--no-cache --threads 1 --tets 30000");
  CHECK(first.size() >= 9);
  for (const char* how : {"--threads 1", "--threads 2", "--threads 2", "--threads 2 --no-cache",
                          "--threads 3 --no-cache"}) {
    INFO(how);
    const std::string found = difference(first, built(std::string(how) + " --tets 30000"));
    CHECK(found == "");
  }
}
