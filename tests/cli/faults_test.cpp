// What the world does to a build half-way: what was there before is still there, one sentence says
// what happened, nothing else is left behind, and the next run works.

#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <set>

#include "support/environment.h"
#include "support/mounted_disk.h"
#include "support/output_files.h"
#include "support/program.h"
#include "support/refusal.h"
#include "support/running.h"
#include "support/small_project.h"

using namespace ecorche;
using test::SmallProject;
namespace fs = std::filesystem;

namespace {

/// A project with an earlier output of another one where its own is to go, and folders of its own
/// for temporary files and cache.
class Bench {
 public:
  Bench() {
    for (const char* name : {"tmp", "cache", "place"}) fs::create_directory(p_.at(name));
    p_.write("other.ecorche", SmallProject::textWith("\"flexor\"", "\"brachialis\""));
    REQUIRE(build("other.ecorche -o place/out").exitCode == 0);
    earlier_ = test::outputFiles(p_.at("place/out"));
    REQUIRE(build("limb.ecorche -o limb").exitCode == 0);
    limb_ = test::outputFiles(p_.at("limb"));
    REQUIRE(limb_ != earlier_);
    fs::remove_all(p_.at("cache/domains"));
  }

  [[nodiscard]] const SmallProject& project() const { return p_; }
  [[nodiscard]] fs::path at(const std::string& name) const { return p_.at(name); }
  [[nodiscard]] const test::Files& limb() const { return limb_; }
  [[nodiscard]] const test::Files& earlier() const { return earlier_; }
  [[nodiscard]] test::Files output() const { return test::outputFiles(p_.at("place/out")); }

  /// @param first  the shell's words before the program: variables, or commands ending in ";"
  [[nodiscard]] test::Outcome build(const std::string& arguments,
                                    const std::string& first = {}) const {
    const auto own = fmt::format("TMPDIR='{}' ECORCHE_CACHE='{}'", p_.at("tmp").string(),
                                 p_.at("cache").string());
    return test::runEcorche("build " + arguments + " --no-preview --quiet --json", p_.folder(),
                            // A later assignment wins
                            first.ends_with(';') ? first + own : own + " " + first);
  }

  /// A shell script in the place of ecorche-worker, for `first`.
  [[nodiscard]] std::string worker(const std::string& script) const {
    const auto file = test::pretendWorker(p_.folder(), script);
    return fmt::format("ECORCHE_WORKER='{}'", file.string());
  }

  /// Hidden files of our own beside the output, in the cache or in the temporary folder.
  [[nodiscard]] std::set<std::string> litter() const {
    std::set<std::string> out;
    for (const char* name : {"tmp", "place", "cache", "cache/domains"}) {
      std::error_code none;
      for (const auto& entry : fs::directory_iterator(p_.at(name), none)) {
        const std::string file = entry.path().filename().string();
        if (file.starts_with('.') || std::string_view(name) == "tmp") out.insert(file);
      }
    }
    return out;
  }

  /// Builds over the earlier output and demands a refusal that costs nothing.
  /// @param words  what the sentence must say, among other things
  void refuses(const std::string& code, const std::vector<std::string>& words,
               const std::string& first, const std::string& more = {}) const {
    // Not from the cache, where no worker is needed
    const auto run = build("limb.ecorche -o place/out --no-cache " + more, first);
    requireRefused(run, code, words);
    CHECK(output() == earlier_);
    CHECK(litter().empty());
  }

  void nextRunWorks() const {
    const auto run = build("limb.ecorche -o place/out");
    INFO(run.err);
    CHECK(run.exitCode == 0);
    CHECK(output() == limb_);
    CHECK(litter().empty());
  }

 private:
  SmallProject p_;
  test::Files limb_, earlier_;
};

int countFindings(const test::Files& output, const std::string& kind) {
  int count = 0;
  const auto report = nlohmann::json::parse(output.at("report.json"));
  for (const auto& f : report.at("findings")) count += f.at("kind") == kind;
  return count;
}

test::Files withoutReport(test::Files files) {
  files.erase("report.json");
  return files;
}

}  // namespace

TEST_CASE("build: a worker that crashes") {
  const Bench bench;
  bench.refuses(
      "MeshingFailed",
      {"worker crashed", "Segmentation fault", "splitting tet 17", "TetGen: ", "Mesh_3: "},
      bench.worker("echo splitting tet 17; ulimit -c 0; kill -SEGV $$"));
  bench.refuses("MeshingFailed", {"Killed, perhaps because memory ran out"},
                bench.worker("kill -KILL $$"));
  bench.nextRunWorks();
}

TEST_CASE("build: a worker that says it is done and is not") {
  const Bench bench;
  const std::string half =
      fmt::format("'{}/ecorche-worker' \"$@\" && truncate -s 1000 \"$3\"", ECORCHE_BIN_DIR);
  for (const std::string& script : {std::string("exit 0"), std::string("echo rubbish > $3"), half})
    bench.refuses("MeshingFailed", {"ecorche-worker left no sound answer"}, bench.worker(script));
  bench.nextRunWorks();
}

TEST_CASE("build: a worker that hangs is stopped with all that it started") {
  const Bench bench;
  bench.refuses("WorkerTimedOut",
                {"did not finish within 0.5 s and was stopped", "counting", "--mesher-timeout"},
                bench.worker("echo counting; sleep 61.2517 & wait"), "--mesher-timeout 0.5");
  CHECK(test::processesWith("61.2517") == 0);
  bench.nextRunWorks();
}

TEST_CASE("build: a worker without memory") {
  const Bench bench;
  bench.refuses("OutOfMemory", {"TetGen gave up: out of memory", "--tets"},
                bench.worker("echo 'error OutOfMemory TetGen gave up: out of memory' >&2; exit 1"));
  bench.nextRunWorks();
}

TEST_CASE("build: no worker") {
  const Bench bench;
  bench.refuses("WorkerMissing", {"ECORCHE_WORKER names no program; unset it or correct it"},
                "ECORCHE_WORKER=/no/such/worker");
  bench.nextRunWorks();
}

TEST_CASE("build: a disk that is full, of temporary files") {
  const Bench bench;
  const auto disk = test::MountedDisk::create(bench.at("small"), 200);
  if (!disk) return;
  const auto inSmall = fmt::format("TMPDIR='{}'", bench.at("small").string());
  // Too small for the tets, then for what the mesher is given, then for anything
  for (const std::size_t filled : {0, 160, 200}) {
    bench.project().write("ballast", std::string(filled << 10, 'x'));
    std::error_code full;
    fs::copy_file(bench.at("ballast"), bench.at("small/ballast"),
                  fs::copy_options::overwrite_existing, full);
    bench.refuses("FileNotWritable", {"No space left on device", "TMPDIR"}, inSmall);
    CHECK(std::distance(fs::directory_iterator(bench.at("small")), {}) == 1);
  }
  bench.nextRunWorks();
}

TEST_CASE("build: a disk that is full, of output") {
  const Bench bench;
  std::size_t bytes = 0;
  for (const auto& [name, content] : bench.limb()) bytes += content.size();
  // Full in the first file, in the last, and all but enough for an output beside the earlier one
  for (const double share : {0.1, 0.95, 1.9}) {
    const auto disk =
        test::MountedDisk::create(bench.at("small"), int(share * double(bytes) / 1024));
    if (!disk) return;
    const bool earlier = share > 1.0;
    if (earlier) REQUIRE(bench.build("other.ecorche -o small/out").exitCode == 0);
    const auto run = bench.build("limb.ecorche -o small/out");
    INFO(share << "\n" << run.err);
    CHECK(run.exitCode == 1);
    CHECK(std::ranges::count(run.err, '\n') == 1);
    CHECK(run.err.find("cannot write the file: No space left on device; choose another folder or "
                       "free some space") != std::string::npos);
    CHECK(std::distance(fs::directory_iterator(bench.at("small")), {}) == long{earlier});
    if (earlier) CHECK(test::outputFiles(bench.at("small/out")) == bench.earlier());
    CHECK(bench.litter().empty());
  }
  bench.nextRunWorks();
}

TEST_CASE("build: a cache that cannot be written costs time, nothing else") {
  const Bench bench;
  const auto buildWith = [&](const fs::path& cache) {
    fs::remove_all(bench.at("place/out"));
    const auto run =
        bench.build("limb.ecorche -o place/out", fmt::format("ECORCHE_CACHE='{}'", cache.string()));
    INFO(cache << "\n" << run.err);
    CHECK(run.exitCode == 0);
    CHECK(run.err.empty());
    CHECK(bench.output() == bench.limb());
    CHECK(bench.litter().empty());
  };
  buildWith("/proc/none");
  buildWith(bench.at("skin.obj"));
  if (const auto disk = test::MountedDisk::create(bench.at("small"), 100)) {
    buildWith(bench.at("small"));
    CHECK(fs::is_empty(bench.at("small/domains")));
    disk->makeReadOnly();
    buildWith(bench.at("small"));
  }
}

TEST_CASE("build: a read-only folder") {
  const Bench bench;
  const auto disk = test::MountedDisk::create(bench.at("small"), 64 << 10);
  if (!disk) return;
  REQUIRE(bench.build("other.ecorche -o small/out").exitCode == 0);
  disk->makeReadOnly();
  for (const char* output : {"small/out", "small/new", "small/deep/new"}) {
    const auto run = bench.build(fmt::format("limb.ecorche -o {}", output));
    INFO(run.err);
    CHECK(run.exitCode == 1);
    CHECK(std::ranges::count(run.err, '\n') == 1);
    CHECK(nlohmann::json::parse(run.out).at("error").at("code") == "FileNotWritable");
  }
  CHECK(std::distance(fs::directory_iterator(bench.at("small")), {}) == 1);
  CHECK(test::outputFiles(bench.at("small/out")) == bench.earlier());
  bench.refuses("FileNotWritable", {"Read-only file system", "TMPDIR"},
                fmt::format("TMPDIR='{}'", bench.at("small").string()));
  bench.nextRunWorks();
}

TEST_CASE("build: a damaged cache is made anew, said once") {
  const Bench bench;
  REQUIRE(bench.build("limb.ecorche -o place/out").exitCode == 0);
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(bench.at("cache/domains")))
    files.push_back(entry.path());
  REQUIRE_FALSE(files.empty());
  const auto flipAt = [](double share) {
    return
        [share](std::string& bytes) { bytes[std::size_t(share * double(bytes.size()))] ^= 0x10; };
  };
  const std::vector<std::function<void(std::string&)>> damages{
      [](std::string& bytes) { bytes.clear(); },
      [](std::string& bytes) { bytes.resize(bytes.size() / 2); },
      [](std::string& bytes) { bytes.pop_back(); },
      [](std::string& bytes) { bytes += "x"; },
      [](std::string& bytes) { bytes = "this is a letter"; },
      flipAt(0.0),
      flipAt(0.5),
      flipAt(0.999999),
  };
  for (std::size_t k = 0; k < damages.size(); ++k) {
    for (const fs::path& file : files) {
      std::string bytes = readFile(file).value();
      damages[k](bytes);
      REQUIRE(writeFileWhole(file, bytes));
    }
    const auto run = bench.build("limb.ecorche -o place/out");
    INFO("damage " << k << "\n" << run.err);
    CHECK(run.exitCode == 0);
    CHECK(withoutReport(bench.output()) == withoutReport(bench.limb()));
    CHECK(countFindings(bench.output(), "cache-damaged") == 1);
    bench.nextRunWorks();
  }
}

TEST_CASE("two builds of one output at once: both succeed, and one of them stands there whole") {
  const Bench bench;
  std::set<std::string> winners;
  for (int round = 0; round < 5; ++round) {
    if (round % 2 == 0) fs::remove_all(bench.at("place/out"));
    if (round % 3 == 0) fs::remove_all(bench.at("cache/domains"));
    const auto start = [&](const std::string& name) {
      return std::make_unique<test::Running>(
          std::vector<std::string>{"build", name + ".ecorche", "-o", "place/out", "--no-preview",
                                   "--quiet", "--threads", "1"},
          bench.project().folder(),
          std::vector<std::string>{"TMPDIR=" + bench.at("tmp").string(),
                                   "ECORCHE_CACHE=" + bench.at("cache").string()},
          bench.at("errors-" + name));
    };
    const auto limb = start("limb");
    const auto other = start("other");
    const int codes[] = {limb->wait(), other->wait()};
    INFO("round " << round << "\n"
                  << readFile(bench.at("errors-limb")).value_or("")
                  << readFile(bench.at("errors-other")).value_or(""));
    CHECK(codes[0] == 0);
    CHECK(codes[1] == 0);
    const auto there = bench.output();
    CHECK((there == bench.limb() || there == bench.earlier()));
    CHECK(bench.litter().empty());
  }
}
