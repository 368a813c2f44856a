// Tets are sized by a draft of the anatomy: small where muscles are thin.

#include <ecorche/engine/bench.h>
#include <ecorche/engine/draft.h>
#include <ecorche/engine/inputs.h>
#include <ecorche/model/project_file.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <utility>

#include "support/small_project.h"

using namespace ecorche;
using mesh::Vector3;

namespace {

std::vector<domain::WantedLength> lengthsOf(const model::Project& project) {
  RunContext run;
  const auto meshes = engine::loadMeshes(project, run);
  REQUIRE(meshes);
  domain::DomainInput input;
  input.skin = meshes->skin;
  input.bones = meshes->bones;
  const auto lengths =
      engine::lengthsFromDraft(input, {.tets = 30000, .useCache = false},
                               engine::curveTissues(project), engine::tissueOptions(project), run);
  if (!lengths) FAIL(lengths.error().text());
  return *lengths;
}

// Mean of what is wanted in the middle of the limb, on either side of the bone
double wantedOn(const std::vector<domain::WantedLength>& lengths, double side) {
  double sum = 0.0;
  int count = 0;
  for (const auto& wanted : lengths) {
    if (std::abs(wanted.point.z()) > 0.03 || side * wanted.point.x() < 0.01) continue;
    sum += wanted.length;
    ++count;
  }
  REQUIRE(count > 10);
  return sum / count;
}

}  // namespace

TEST_CASE("a weaker muscle is thinner and wants smaller tets") {
  const test::SmallProject p;
  auto project = model::loadProject(p.at("limb.ecorche"));
  REQUIRE(project);
  const auto alike = lengthsOf(*project);
  CHECK(wantedOn(alike, 1.0) == Approx(wantedOn(alike, -1.0)).epsilon(0.1));
  for (auto& point : project->tissues[1].curves[0].points) point.tissue = 0.5;
  const auto weak = lengthsOf(*project);
  CHECK(wantedOn(weak, -1.0) < 0.8 * wantedOn(weak, 1.0));
  // The same again, and on the surfaces of muscles alone
  const auto again = lengthsOf(*project);
  REQUIRE(again.size() == weak.size());
  for (std::size_t i = 0; i < weak.size(); ++i) {
    CHECK(again[i].point == weak[i].point);
    CHECK(again[i].length == weak[i].length);
  }
}

TEST_CASE("the model times 1024 gets the same tets, draft and all") {
  const test::SmallProject p;
  const auto project = model::loadProject(p.at("limb.ecorche"));
  REQUIRE(project);
  RunContext run;
  const auto cases = engine::benchScale(*project, {1024.0}, std::nullopt, run);
  if (!cases) FAIL(cases.error().text());
  CHECK(cases->at(0).sameTets);
  CHECK(cases->at(0).shareChange == 0.0);
}

TEST_CASE("a domain that does not know the curves is the same whatever is drawn") {
  const test::SmallProject p;
  auto project = model::loadProject(p.at("limb.ecorche"));
  REQUIRE(project);
  RunContext run;
  const auto domainOf = [&](engine::Sizing sizing) {
    auto prepared = engine::prepareDomain(*project, {.useCache = false, .sizing = sizing}, run);
    if (!prepared) FAIL(prepared.error().text());
    return std::move(prepared->build.domain.mesh);
  };
  const mesh::TetMesh before = domainOf(engine::Sizing::None);
  const mesh::TetMesh known = domainOf(engine::Sizing::Curves);
  project->tissues[0].curves[0].points[1].at.x() += 0.005;
  const mesh::TetMesh after = domainOf(engine::Sizing::None);
  CHECK(after.V == before.V);
  CHECK(after.T == before.T);
  const mesh::TetMesh moved = domainOf(engine::Sizing::Curves);
  CHECK((moved.V.rows() != known.V.rows() || moved.V != known.V));
}

TEST_CASE("muscles of a preview are those of the build") {
  const test::SmallProject p;
  const auto project = model::loadProject(p.at("limb.ecorche"));
  REQUIRE(project);
  RunContext run;
  // A domain that does not know the curves is coarse at both muscles' ends
  const std::pair<engine::Sizing, double> limits[] = {{engine::Sizing::Curves, 0.03},
                                                      {engine::Sizing::None, 0.06}};
  for (const auto& [sizing, limit] : limits) {
    const auto bench = engine::benchPreview(*project, 30000, sizing, 30000, run);
    if (!bench) FAIL(bench.error().text());
    REQUIRE(bench->cases.size() == 2);
    CHECK(std::abs(static_cast<double>(bench->cases[0].tets) / 30000.0 - 1.0) < 0.2);
    CHECK(bench->ours.largest < limit);
  }
}
