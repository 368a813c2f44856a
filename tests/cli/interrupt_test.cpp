// A build that is interrupted or killed at any moment leaves its output whole or absent, and nobody
// running.

#include <ecorche/domain/domain_cache.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <map>
#include <random>

#include "support/cases.h"
#include "support/environment.h"
#include "support/output_files.h"
#include "support/patience.h"
#include "support/program.h"
#include "support/running.h"
#include "support/small_project.h"

using namespace ecorche;
using test::SmallProject;
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

/// Two projects that differ, their outputs, and a place where builds are cut short.
class CutShort {
 public:
  explicit CutShort(std::uint64_t seed) : random_(seed) {
    fs::create_directory(project_.at("tmp"));
    fs::create_directory(project_.at("place"));
    project_.write("other.ecorche", SmallProject::textWith("\"flexor\"", "\"brachialis\""));
    for (const char* name : {"limb", "other"}) {
      const auto begin = Clock::now();
      auto run = start(name, fmt::format("whole/{}", name));
      REQUIRE(run->wait() == 0);
      whole_[name] = test::outputFiles(project_.at(fmt::format("whole/{}", name)));
      seconds_ = std::min(seconds_, std::chrono::duration<double>(Clock::now() - begin).count());
      REQUIRE(whole_[name].size() == 9);
    }
    REQUIRE(whole_["limb"] != whole_["other"]);
  }

  [[nodiscard]] std::unique_ptr<test::Running> start(
      const std::string& name, const std::string& output = "place/out") const {
    return std::make_unique<test::Running>(
        std::vector<std::string>{"build", name + ".ecorche", "-o", output, "--no-preview",
                                 "--quiet"},
        project_.folder(),
        std::vector<std::string>{"TMPDIR=" + project_.at("tmp").string(),
                                 "ECORCHE_CACHE=" + project_.at("cache").string()},
        project_.at("errors"));
  }

  // A moment somewhere in a run: part `k` of `n`, and a little more than the end
  void waitFor(int k, int n) {
    const double share = (k + std::uniform_real_distribution<>()(random_)) / n;
    std::this_thread::sleep_for(std::chrono::duration<double>(1.1 * share * seconds_));
  }

  // The moment when a file of the output has just been staged
  void waitForStaged(const test::Running& run, const std::string& file) {
    while (run.runs()) {
      std::error_code gone;
      for (const auto& entry : fs::directory_iterator(project_.at("place"), gone)) {
        if (entry.path().filename() != "out" && fs::exists(entry.path() / file)) return;
      }
    }
  }

  // The moment when a domain is being stored
  void waitForCache(const test::Running& run) {
    while (run.runs()) {
      std::error_code none;
      for (const auto& entry : fs::directory_iterator(project_.at("cache/domains"), none)) {
        if (entry.path().extension() != ".ecd") return;
      }
    }
  }

  // "absent", or whose output stands there, to the last byte
  [[nodiscard]] std::string outcome() const {
    const fs::path out = project_.at("place/out");
    if (!fs::exists(out)) return "absent";
    const auto there = test::outputFiles(out);
    for (const auto& [name, files] : whole_) {
      if (there == files) return name;
    }
    return "broken";
  }

  [[nodiscard]] std::string errors() const {
    return readFile(project_.at("errors")).value_or(std::string());
  }
  // Hidden siblings of the output
  [[nodiscard]] long leftovers() const {
    return std::distance(fs::directory_iterator(project_.at("place")), {}) -
           long{fs::exists(project_.at("place/out"))};
  }
  [[nodiscard]] bool noScratch() const { return fs::is_empty(project_.at("tmp")); }
  // Workers name their files, which lie in our own temporary folder
  [[nodiscard]] bool nobodyRuns() const {
    const auto end = Clock::now() + std::chrono::seconds(5 * test::kPatience);
    while (test::processesWith(project_.at("tmp").string()) > 0) {
      if (Clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    return true;
  }
  void removeOutput() const { fs::remove_all(project_.at("place/out")); }

  // Every domain in the cache can be had; hidden files beside them are counted
  [[nodiscard]] bool cacheIsSound() const {
    const test::Environment here("ECORCHE_CACHE", project_.at("cache").string());
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(project_.at("cache/domains"), none)) {
      Findings findings;
      if (entry.path().extension() == ".ecd" &&
          !domain::loadCached(entry.path().stem().string(), findings))
        return false;
    }
    return true;
  }
  [[nodiscard]] long cacheLeftovers() const {
    long count = 0;
    for (const auto& entry : fs::directory_iterator(project_.at("cache/domains")))
      count += entry.path().extension() != ".ecd";
    return count;
  }
  void emptyCache() const { fs::remove_all(project_.at("cache")); }

 private:
  SmallProject project_;
  std::mt19937_64 random_;
  std::map<std::string, test::Files> whole_;
  double seconds_ = 1e9;
};

/// Random moments, over no output and over an earlier one together.
int kills() {
  const char* wanted = std::getenv("ECORCHE_KILLS");
  return wanted != nullptr ? std::atoi(wanted) : test::kSanitized ? 6 : 24;
}

constexpr int kMoments = test::kSanitized ? 4 : 12;
constexpr const char* kStaged[] = {".",     "anatomy.vtu", "anatomy.mesh",
                                   "bones", "model.json",  "report.json"};

}  // namespace

TEST_CASE("a build killed at any moment leaves a whole output or none, a sound cache, no worker") {
  CutShort bench(Catch::rngSeed());
  std::map<std::string, int> seen;
  const auto judge = [&](test::Running& run, const std::vector<std::string>& allowed) {
    run.send(SIGKILL);
    run.wait();
    const std::string outcome = bench.outcome();
    ++seen[outcome];
    INFO(outcome);
    CHECK(std::ranges::count(allowed, outcome) == 1);
    CHECK(bench.nobodyRuns());
    CHECK(bench.cacheIsSound());
    return outcome;
  };

  // Every third time domains come from the cache, as far as those before got
  const int moments = (kills() + 1) / 2;
  for (int k = 0; k < moments; ++k) {
    if (k % 3 != 2) bench.emptyCache();
    auto run = bench.start("limb");
    bench.waitFor(k, moments);
    judge(*run, {"absent", "limb"});
    bench.removeOutput();
  }
  for (const char* file : kStaged) {
    auto run = bench.start("limb");
    bench.waitForStaged(*run, file);
    judge(*run, {"absent", "limb"});
    bench.removeOutput();
  }
  CHECK(seen["absent"] > 0);

  // Over an earlier output: that one or the new one
  REQUIRE(bench.start("other")->wait() == 0);
  CHECK(bench.leftovers() == 0);
  CHECK(bench.noScratch());
  std::string there = "other";
  const auto next = [&] { return there == "other" ? "limb" : "other"; };
  for (int k = 0; k < moments; ++k) {
    if (k % 3 != 2) bench.emptyCache();
    auto run = bench.start(next());
    bench.waitFor(k, moments);
    there = judge(*run, {"limb", "other"});
  }
  for (const char* file : kStaged) {
    auto run = bench.start(next());
    bench.waitForStaged(*run, file);
    there = judge(*run, {"limb", "other"});
  }
  CHECK(seen["limb"] + seen["other"] > 0);

  // The next run clears up, in the cache whatever domain it is that it stores
  bench.emptyCache();
  auto storing = bench.start(next());
  bench.waitForCache(*storing);
  judge(*storing, {"limb", "other"});
  there = bench.outcome();
  REQUIRE(bench.start(next())->wait() == 0);
  CHECK(bench.outcome() == next());
  CHECK(bench.leftovers() == 0);
  CHECK(bench.cacheLeftovers() == 0);
  CHECK(bench.noScratch());
}

TEST_CASE("an interrupted build answers 130 and leaves nothing behind") {
  CutShort bench(Catch::rngSeed());
  REQUIRE(bench.start("other")->wait() == 0);
  int interrupted = 0;
  for (int k = 0; k < kMoments; ++k) {
    if (k % 3 != 2) bench.emptyCache();
    auto run = bench.start("limb");
    bench.waitFor(k, kMoments);
    run->send(k % 3 == 0 ? SIGTERM : SIGINT);
    const int code = run->wait();
    const std::string outcome = bench.outcome();
    INFO(k << ": exit " << code << ", " << outcome << "\n" << bench.errors());
    if (code == 0) {
      CHECK(outcome == "limb");
    } else {
      CHECK(outcome == "other");
      // Before the program has begun to listen, the signal itself ends it
      CHECK((code == 130 || (k == 0 && code < 0)));
      if (code == 130) CHECK(bench.errors() == "ecorche: interrupted; nothing was written\n");
      interrupted += code == 130;
    }
    CHECK(bench.leftovers() == 0);
    CHECK(bench.noScratch());
    CHECK(bench.nobodyRuns());
    if (outcome == "limb") REQUIRE(bench.start("other")->wait() == 0);
  }
  CHECK(interrupted > 0);
}
