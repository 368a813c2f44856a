#include <ecorche/mesh/surface_query.h>
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <thread>

#include "damaged/rows.h"
#include "domain/soundness.h"
#include "support/cases.h"
#include "support/patience.h"

using namespace ecorche;
using namespace ecorche::domain;

namespace ecorche::test {

SurfaceMesh goodSkin() { return egg({0, 0, 0}, {0.05, 0.045, 0.15}, 4, "skin"); }
SurfaceMesh goodHumerus() { return egg({0, 0, 0.06}, {0.018, 0.016, 0.05}, 3, "humerus"); }
SurfaceMesh goodUlna() { return egg({0, 0, -0.06}, {0.016, 0.018, 0.05}, 3, "ulna"); }
DomainInput goodLimb() {
  DomainInput in;
  in.skin = goodSkin();
  in.bones = {goodHumerus(), goodUlna()};
  return in;
}

Made withSkin(SurfaceMesh skin) { return withSkin(std::move(skin), goodSkin()); }
Made withSkin(SurfaceMesh skin, SurfaceMesh meant) {
  Made out{goodLimb(), goodLimb(), {}};
  out.input.skin = std::move(skin);
  out.truth.skin = std::move(meant);
  return out;
}
Made withBones(std::vector<SurfaceMesh> bones) { return withBones(bones, bones); }
Made withBones(std::vector<SurfaceMesh> bones, std::vector<SurfaceMesh> meant) {
  Made out{goodLimb(), goodLimb(), {}};
  out.input.bones = std::move(bones);
  out.truth.bones = std::move(meant);
  return out;
}

}  // namespace ecorche::test

namespace {

using test::Made;
using test::Row;
using Clock = std::chrono::steady_clock;

// Of one row [s]; the slowest takes a tenth of it, where nothing else runs
constexpr double kTimeLimit = 240.0 * test::kPatience;
constexpr std::int64_t kTets = 6000;
// Coarser than usual, so that a hundred domains take no minutes
constexpr double kTolerance = 0.004;

/// The volume that was meant, another way: points of a lattice that are in the skin, on the kept
/// side, and in nothing that is taken out.
double latticeVolume(const DomainInput& truth) {
  const mesh::Box box = mesh::boundingBox(truth.skin);
  const mesh::SurfaceQuery skin(truth.skin);
  std::vector<mesh::SurfaceQuery> holes;
  std::vector<mesh::Box> boxes;
  for (const auto* list : {&truth.bones, &truth.obstacles, &truth.cavities}) {
    for (const auto& m : *list) {
      holes.emplace_back(m);
      boxes.push_back(mesh::boundingBox(m));
    }
  }
  constexpr int kAcross = 44;
  const mesh::Vector3 cell = (box.hi - box.lo) / kAcross;
  const auto kept = [&](const mesh::Vector3& p) {
    for (const CutPlane& plane : truth.cutPlanes) {
      if (plane.normal.dot(p - plane.point) < 0.0) return false;
    }
    if (skin.windingNumber(p).value_or(0) < 1) return false;
    for (std::size_t h = 0; h < holes.size(); ++h) {
      if ((boxes[h].lo.array() > p.array()).any() || (boxes[h].hi.array() < p.array()).any())
        continue;
      if (holes[h].windingNumber(p).value_or(0) != 0) return false;
    }
    return true;
  };
  std::int64_t count = 0;
  for (int x = 0; x < kAcross; ++x) {
    for (int y = 0; y < kAcross; ++y) {
      for (int z = 0; z < kAcross; ++z) {
        // Each row of the lattice starts elsewhere, so that no face lies along it
        const double shift = 0.37 + 0.23 * ((x * 7 + y * 3) % 11) / 11.0;
        const Eigen::Array3d at(x + 0.51, y + 0.49, z + shift);
        count += kept(box.lo + (at * cell.array()).matrix());
      }
    }
  }
  return static_cast<double>(count) * cell.prod();
}

/// How far the report itself says that the volume may be off [m³].
double statedVolume(const DomainBuild& built) {
  double out = 0.0;
  std::map<std::string, double> area;
  for (std::size_t f = 0; f < built.domain.boundaryTag.size(); ++f) {
    const BoundaryTag tag = built.domain.boundaryTag[f];
    if (tag.kind == BoundaryTag::Kind::CutPlane) continue;
    const std::string name = tag.kind == BoundaryTag::Kind::Skin ? "skin"
                             : tag.kind == BoundaryTag::Kind::Bone
                                 ? built.domain.boneNames[static_cast<std::size_t>(tag.index)]
                                 : "";
    area[name] += mesh::surfaceArea(built.domain.mesh.V,
                                    built.domain.boundaryF.row(static_cast<Eigen::Index>(f)));
  }
  double largestMean = 0.0;
  for (const SurfaceDeviation& d : built.report.deviations) {
    const double mean = std::max(d.meanFromInput, d.meanToInput);
    largestMean = std::max(largestMean, mean);
    if (area.contains(d.name)) out += mean * area.at(d.name);
  }
  return out + largestMean * area[""];
}

/// Cancels a run that takes too long, so that a hang becomes a failed row.
class Watchdog {
 public:
  Watchdog(RunContext& run, double seconds)
      : thread_([&run, seconds, this] {
          std::unique_lock lock(mutex_);
          if (!wake_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return over_; }))
            run.cancel();
        }) {}
  ~Watchdog() {
    {
      const std::lock_guard lock(mutex_);
      over_ = true;
    }
    wake_.notify_all();
    thread_.join();
  }

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  bool over_ = false;
  std::thread thread_;
};

std::string joined(const std::set<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + word;
  return out.empty() ? "nothing" : out;
}

/// A line of the table in docs/damaged_meshes.md, where ECORCHE_DAMAGED_TABLE names a file.
void keepLine(const std::string& line) {
  const char* file = std::getenv("ECORCHE_DAMAGED_TABLE");
  if (file != nullptr) std::ofstream(file, std::ios::app) << line << "\n";
}

void runRow(const Row& row, double timeLimit = kTimeLimit) {
  INFO(row.name);
  const Made made = row.make();
  DomainOptions options;
  options.tets = kTets;
  options.surfaceToleranceRel = kTolerance;
  options.useCache = false;
  RunContext run;
  const auto begin = Clock::now();
  const auto built = [&] {
    const Watchdog watchdog(run, timeLimit);
    return buildDomain(made.input, options, run);
  }();
  const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();

  if (!built) {
    INFO(built.error().text());
    const bool expected = row.error == built.error().code;
    CHECK(expected);
    keepLine(fmt::format("| {} | `{}`: {} | | {:.1f} |", row.name, name(built.error().code),
                         built.error().text(), seconds));
    if (!expected) return;
    CHECK(built.error().message.size() > 20);
    CHECK(built.error().place.object.size() > 0);
    return;
  }
  CHECK_FALSE(row.error.has_value());
  test::requireSound(built->domain);
  std::set<std::string> told;
  for (const Findings* list : {&made.asked, &built->report.findings}) {
    for (const Finding& f : *list) {
      if (f.kind != "slivers") told.insert(f.kind);  // of tets, not of meshes
      CHECK(f.message.size() > 10);
    }
  }
  std::string all;
  for (const Finding& f : built->report.findings) all += f.kind + ": " + f.message + "\n";
  INFO(all);
  CHECK(joined(told) == joined(std::set<std::string>(row.told.begin(), row.told.end())));
  CHECK(built->report.maxDeviation <= built->report.tolerance);

  const double meant = latticeVolume(made.truth);
  const double off = built->domain.volume - meant;
  // The lattice itself is good for 0.1 %
  const double allowed = 1e-3 * meant + statedVolume(*built) + row.slack * std::pow(row.sizeRel, 3);
  CHECK(std::abs(off) <= allowed);
  keepLine(fmt::format("| {} | {} tets; {} | {:+.2f} % | {:.1f} |", row.name, built->report.tets,
                       joined(told), 100.0 * off / meant, seconds));
}

void runAll(const std::vector<Row>& rows) {
  if (const char* only = std::getenv("ECORCHE_DAMAGED_ROW")) {
    for (const Row& row : rows) {
      if (row.name.find(only) != std::string::npos) runRow(row);
    }
    return;
  }
  for (const std::size_t row : test::casesHere(rows.size())) runRow(rows[row]);
}

}  // namespace

/// Not of the suite: `test_damaged "[heavy]"`.
TEST_CASE("a sculpt of three million triangles is thinned out, not meshed", "[.heavy]") {
  const auto sculpt = [] {
    return test::withSkin(test::ringedEgg({0, 0, 0}, {0.05, 0.045, 0.15}, 999, 1500, "skin"),
                          test::ringedEgg({0, 0, 0}, {0.05, 0.045, 0.15}, 99, 150, "skin"));
  };
  runRow({"3,000,000 faces", sculpt, std::nullopt, {"dense"}}, 1200.0);
}

TEST_CASE("damaged skins end in a domain that is right, or in the exact error") {
  runAll(test::skinRows());
}
TEST_CASE("damaged bones end in a domain that is right, or in the exact error") {
  runAll(test::boneRows());
}
TEST_CASE(
    "units, cut planes, obstacles and cavities end in a domain that is right, or in the error") {
  runAll(test::togetherRows());
}
