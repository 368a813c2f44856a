#include <ecorche/authoring/offset_skin.h>
#include <ecorche/domain/build_domain.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_topology.h>

#include <catch2/catch.hpp>

#include "domain/soundness.h"
#include "support/paths.h"
#include "support/shapes.h"

using namespace ecorche;

namespace {

/// In one piece, closed, uncrossed, everywhere at least this far from the bones, and near.
void requireSkin(const mesh::SurfaceMesh& skin, const std::vector<mesh::SurfaceMesh>& bones,
                 double distance) {
  CHECK(mesh::isUncrossed(skin));
  CHECK(mesh::components(skin.F).count == 1);
  const mesh::SurfaceMesh all = mesh::joined(bones, "bones");
  const mesh::SurfaceQuery toBones(all), toSkin(skin);
  for (Eigen::Index v = 0; v < all.V.rows(); v += 7) {
    const mesh::Vector3 p = all.V.row(v).transpose();
    CHECK(toSkin.windingNumber(p).value_or(0) == 1);
    CHECK(toSkin.distance(p) > 0.8 * distance);
  }
}

}  // namespace

TEST_CASE("bones far apart get one skin, bones without area get none") {
  RunContext run;
  const std::vector<mesh::SurfaceMesh> bones{test::sphere({0, 0, 0}, 0.02, 3),
                                             test::sphere({0.3, 0, 0}, 0.02, 3)};
  const auto skin = authoring::offsetSkin(bones, 0.01, run);
  REQUIRE(skin);
  requireSkin(*skin, bones, 0.01);

  auto broken = bones;
  broken[1].V(3, 0) = std::nan("");
  broken[1].name = "broken";
  const auto refused = authoring::offsetSkin(broken, 0.01, run);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::NonFiniteVertex);
  CHECK(refused.error().place.object == "broken");
}

TEST_CASE("a real bone in a skin of its own becomes a domain") {
  if (!test::haveData("bmf_bones/PatellaL.obj")) return;
  for (const char* file : {"PatellaL.obj", "CalcaneusR.obj"}) {
    INFO(file);
    RunContext run;
    auto bone = mesh::readMesh(test::dataFolder() / "bmf_bones" / file, {}, run).value();
    bone.name = "bone";
    const double distance = authoring::kSkinOffsetRel * mesh::boundingBox(bone).diagonal();
    const auto skin = authoring::offsetSkin({bone}, distance, run);
    REQUIRE(skin);
    domain::DomainInput input;
    input.skin = *skin;
    input.bones = {bone};
    domain::DomainOptions options;
    options.tets = 15000;
    options.surfaceToleranceRel = 0.004;
    options.useCache = false;
    const auto built = domain::buildDomain(input, options, run);
    if (!built) FAIL(built.error().text());
    test::requireSound(built->domain);
    CHECK(built->report.maxDeviation <= built->report.tolerance);
  }
}
