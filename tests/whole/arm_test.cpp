// What `ecorche build` writes, measured by meshio and vtk (measure.py): the small project, and the
// arm at 200 k tets, which ctest builds before (fixture "arm").

#include <algorithm>
#include <catch2/catch.hpp>

#include "support/program.h"
#include "support/python.h"
#include "support/small_project.h"

using namespace ecorche;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

bool haveArm() {
  if (fs::exists(fs::path(ECORCHE_ARM) / "report.json")) return true;
  FAIL("no " << ECORCHE_ARM << "; run this through ctest, which builds the arm first");
  return false;
}

// Everything that does not depend on how close the domain is to its input
void requireSound(const json& seen, const json& report) {
  CHECK(seen.at("only_tets") == true);
  CHECK(seen.at("readers_differ") == 0);
  CHECK(seen.at("tets_not_positive") == 0);
  CHECK(seen.at("most_tets_on_a_face") == 2);
  CHECK(seen.at("faces_with_tets_on_one_side") == 0);
  for (const auto& [what, count] : seen.at("muscle_surfaces").items()) {
    INFO(what);
    CHECK(count == 0);
  }

  // Volumes: tets, what the boundary encloses, the tissues' sum, and what the report says of each
  const double volume = seen.at("volume");
  CHECK(volume > 0.0);
  CHECK(seen.at("volume_inside_boundary").get<double>() == Approx(volume).epsilon(1e-9));
  double sum = 0.0;
  std::size_t tets = 0;
  for (const auto& [name, tissue] : seen.at("tissues").items()) {
    INFO(name << ": " << tissue.dump());
    sum += tissue.at("volume").get<double>();
    tets += tissue.at("tets").get<std::size_t>();
    CHECK(tissue.at("longest_or_shortest_fiber").get<double>() < 1e-9);
    const auto told = std::ranges::find_if(report.at("tissues"),
                                           [&](const json& t) { return t.at("name") == name; });
    REQUIRE(told != report.at("tissues").end());
    CHECK(told->at("volume_cm3").get<double>() ==
          Approx(1e6 * tissue.at("volume").get<double>()).epsilon(1e-9));
    if (tissue.at("kind") != "muscle") continue;
    CHECK(tissue.at("pieces") == 1);
    CHECK(tissue.at("triangles_missing") == 0);
    CHECK(tissue.at("split_edges") == 0);
  }
  CHECK(sum == Approx(volume).epsilon(1e-9));
  CHECK(tets == seen.at("tets"));
}

json reportIn(const fs::path& folder) {
  return json::parse(readFile(folder / "report.json").value());
}

}  // namespace

TEST_CASE("meshio and vtk find a small build sound") {
  if (!test::haveReaders()) return;
  const test::SmallProject p;
  REQUIRE(test::runEcorche("build limb.ecorche -o out --no-preview --no-cache -q", p.folder())
              .exitCode == 0);
  requireSound(test::pythonOn("whole/measure.py", p.at("out")), reportIn(p.at("out")));
}

TEST_CASE("meshio and vtk find the arm sound") {
  if (!test::haveReaders() || !haveArm()) return;
  const json seen = test::pythonOn("whole/measure.py", ECORCHE_ARM);
  requireSound(seen, reportIn(ECORCHE_ARM));
  CHECK(seen.at("tets") > 200000);
  CHECK(seen.at("tissues").size() >= 11);
}

TEST_CASE("vtk finds the arm's skin and bones where they were") {
  if (!test::haveReaders() || !haveArm()) return;
  const json seen = test::pythonOn("whole/measure.py", fs::path(ECORCHE_ARM), "deviations");
  CHECK(seen.size() == 7);
  for (const auto& [name, share] : seen.items()) {
    INFO(name);
    CHECK(share.get<double>() <= 0.001);
  }
}

TEST_CASE("the arm passes every check, from its files alone") {
  if (!haveArm()) return;
  const test::TempFolder temp;
  const auto run =
      test::runEcorche(fmt::format("check '{}' --json --quiet", ECORCHE_ARM), temp.path());
  CHECK(run.exitCode == 0);
  const json answer = json::parse(run.out);
  CHECK(answer.at("checks").size() >= 20);
  for (const auto& check : answer.at("checks")) {
    INFO(check.dump(2));
    CHECK(check.at("pass") == true);
  }
}
