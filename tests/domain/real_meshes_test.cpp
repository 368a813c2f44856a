// Smaller brothers of bench/real_meshes.cpp: other people's meshes as they are.

#include <ecorche/domain/build_domain.h>
#include <ecorche/mesh/read_mesh.h>
#include <support/paths.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

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
  // Coarse walls cut the body's roundness off, by no more than they stray from it
  CHECK(std::abs(built->report.volume - volume) <=
        built->report.maxDeviation * mesh::surfaceArea(input.skin.V, input.skin.F));
}

TEST_CASE("a human pelvis of shells that share faces, beside knees that cut themselves") {
  if (!test::haveData("hra_male/VH_M_Skin.glb")) return;
  RunContext run;
  const auto part = [&](const char* file) {
    auto mesh = mesh::readMesh(test::dataFolder() / "hra_male" / file, {1.0}, run).value();
    mesh.name = file;
    return mesh;
  };
  DomainInput input;
  input.skin = part("VH_M_Skin.glb");
  input.bones = {part("VH_M_Knee_L.glb"), part("VH_M_Knee_R.glb")};
  const auto pelvis = part("VH_M_Pelvis.glb");
  for (std::size_t p = 0; p < pelvis.parts.size(); ++p) {
    if (pelvis.parts[p].name.find("compact_bone") != std::string::npos)
      input.bones.push_back(mesh::partOf(pelvis, p));
  }
  REQUIRE(input.bones.size() == 8);
  const auto built = buildDomain(input, coarse(60000), run);
  requireGood(built);
  CHECK(built->report.mesher == "TetGen");
  CHECK(built->report.wraps == 0);
  CHECK(built->report.bonesLeftOut == 0);
}
