#include <ecorche/domain/build_domain.h>
#include <ecorche/mesh/read_mesh.h>
#include <support/paths.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "soundness.h"

using namespace ecorche;
using namespace ecorche::domain;

TEST_CASE("the hind limb of a real dog") {
  if (!test::haveData("dog/SKINbody.stl")) return;
  const auto folder = test::dataFolder() / "dog";
  RunContext run;
  DomainInput input;
  input.skin = mesh::readMesh(folder / "SKINbody.stl", {}, run).value();
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "bones")) {
    files.push_back(entry.path());
  }
  std::ranges::sort(files);
  for (const auto& file : files) {
    input.bones.push_back(mesh::readMesh(file, {}, run).value());
    input.bones.back().name = file.stem().string();
  }
  input.cutPlanes = {{"median", {0, 0, 0}, {0, 1, 0}}, {"front", {-0.2, 0, 0}, {-1, 0, 0}}};
  DomainOptions options;
  options.tets = 100000;
  options.useCache = false;

  const auto built = buildDomain(input, options, run);
  REQUIRE(built);
  const Domain& d = built->domain;
  test::requireSound(d);
  CHECK_FALSE(built->report.fallback);
  CHECK(built->report.components == 1);
  CHECK(built->report.maxDeviation <= built->report.tolerance);
  CHECK(std::abs(static_cast<double>(d.mesh.T.rows()) / 100000.0 - 1.0) < 0.2);
  for (int plane = 0; plane < 2; ++plane) {
    CHECK(test::farthestFromPlane(d, plane, input.cutPlanes[static_cast<std::size_t>(plane)]) ==
          0.0);
  }
  // The claws reach out of the skin, and no bone of another limb is left
  CHECK(std::ranges::count(built->report.findings, "pokes-out", &Finding::kind) == 4);
  CHECK(built->report.bonesUsed >= 50);
  CHECK(built->report.bonesUsed <= 60);
  const auto femur = std::ranges::find(d.boneNames, "BONEFemoris_L") - d.boneNames.begin();
  CHECK(test::areaOf(d, {BoundaryTag::Kind::Bone, static_cast<std::int32_t>(femur)}) > 0.01);
  // Flat tets are left only where sharp edges of the walls force them: corners all on walls
  const Eigen::MatrixX2d range = mesh::dihedralRangeDeg(d.mesh);
  std::vector<std::uint8_t> onWall(static_cast<std::size_t>(d.mesh.V.rows()), 0);
  for (Eigen::Index i = 0; i < d.boundaryF.size(); ++i) {
    onWall[static_cast<std::size_t>(d.boundaryF.data()[i])] = 1;
  }
  std::int64_t flat = 0;
  std::int64_t flatInside = 0;
  for (Eigen::Index t = 0; t < d.mesh.T.rows(); ++t) {
    if (range(t, 0) >= 5.0) continue;
    int walls = 0;
    for (int k = 0; k < 4; ++k) walls += onWall[static_cast<std::size_t>(d.mesh.T(t, k))];
    ++flat;
    flatInside += walls < 4;
  }
  CHECK(static_cast<double>(flat) < 5e-3 * static_cast<double>(d.mesh.T.rows()));
  CHECK(static_cast<double>(flatInside) < 5e-4 * static_cast<double>(d.mesh.T.rows()));
}
