// Smaller brothers of bench/real_meshes.cpp: other people's meshes as they are.

#include <ecorche/domain/build_domain.h>
#include <ecorche/mesh/read_mesh.h>
#include <support/paths.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "soundness.h"

using namespace ecorche;
using namespace ecorche::domain;

namespace {

DomainOptions coarse(std::int64_t tets) {
  DomainOptions o;
  o.tets = tets;
  o.surfaceToleranceRel = 0.003;
  o.useCache = false;
  return o;
}

void requireGood(const Result<DomainBuild>& built) {
  if (!built) FAIL(built.error().text());
  test::requireSound(built->domain);
  CHECK(built->report.maxDeviation <= built->report.tolerance);
  CHECK(built->report.components == 1);
}

}  // namespace

TEST_CASE("a human body without bones") {
  if (!test::haveData("makehuman/base.obj")) return;
  RunContext run;
  const auto all = mesh::readMesh(test::dataFolder() / "makehuman/base.obj", {0.1}, run).value();
  const auto body = std::ranges::find(all.parts, "body", &mesh::Part::name);
  REQUIRE(body != all.parts.end());
  DomainInput input;
  input.skin = mesh::partOf(all, static_cast<std::size_t>(body - all.parts.begin()));
  input.skin.name = "skin";
  const double volume = mesh::signedVolume(input.skin.V, input.skin.F);
  const auto built = buildDomain(input, coarse(40000), run);
  requireGood(built);
  CHECK(built->report.volume == Approx(volume).epsilon(0.02));
}

TEST_CASE("a human skin around knees in patches and a pelvis whose parts overlap") {
  if (!test::haveData("hra_male/VH_M_Skin.glb")) return;
  const auto folder = test::dataFolder() / "hra_male";
  RunContext run;
  DomainInput input;
  input.skin = mesh::readMesh(folder / "VH_M_Skin.glb", {}, run).value();
  input.skin.name = "skin";
  input.bones.push_back(mesh::readMesh(folder / "VH_M_Knee_L.glb", {}, run).value());
  input.bones.back().name = "knee";
  const auto pelvis = mesh::readMesh(folder / "VH_M_Pelvis.glb", {}, run).value();
  for (std::size_t p = 0; p < pelvis.parts.size(); ++p) {
    if (pelvis.parts[p].name.find("compact_bone") != std::string::npos)
      input.bones.push_back(mesh::partOf(pelvis, p));
  }
  REQUIRE(input.bones.size() > 3);
  const auto built = buildDomain(input, coarse(60000), run);
  requireGood(built);
  CHECK(test::hasFinding(built->report.findings, "united"));
  CHECK(built->report.bonesUsed == std::ssize(input.bones));
}
