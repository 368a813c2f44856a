#include <ecorche/core/files.h>
#include <ecorche/domain/build_domain.h>
#include <support/paths.h>
#include <support/shapes.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include "soundness.h"

using namespace ecorche;
using namespace ecorche::domain;
using mesh::Vector3;

namespace {

mesh::SurfaceMesh named(mesh::SurfaceMesh mesh, std::string name) {
  mesh.name = std::move(name);
  return mesh;
}

/// A ball of radius 10 cm around one of 3 cm.
DomainInput ballInBall() {
  DomainInput input;
  input.skin = named(test::sphere({0, 0, 0}, 0.1, 4), "skin");
  input.bones = {named(test::sphere({0.01, 0, 0}, 0.03, 3), "bone")};
  return input;
}

DomainOptions options(std::int64_t tets) {
  DomainOptions o;
  o.tets = tets;
  o.useCache = false;
  return o;
}

Result<DomainBuild> build(const DomainInput& input, const DomainOptions& o) {
  RunContext run;
  return buildDomain(input, o, run);
}

ErrorCode codeOf(const Result<DomainBuild>& result) {
  REQUIRE_FALSE(result);
  return result.error().code;
}

}  // namespace

TEST_CASE("a bone in a skin: a sound domain of the right volume and size") {
  const DomainInput input = ballInBall();
  const auto built = build(input, options(20000));
  REQUIRE(built);
  const Domain& d = built->domain;
  test::requireSound(d);
  const double volume = mesh::signedVolume(input.skin.V, input.skin.F) -
                        mesh::signedVolume(input.bones[0].V, input.bones[0].F);
  CHECK(d.volume == Approx(volume).epsilon(0.005));
  CHECK(built->report.maxDeviation <= built->report.tolerance);
  CHECK(built->report.tolerance == Approx(0.001 * mesh::boundingBox(input.skin).diagonal()));
  CHECK(std::abs(static_cast<double>(d.mesh.T.rows()) - 20000.0) < 5000.0);
  CHECK(built->report.tets == d.mesh.T.rows());
  CHECK(built->report.freeVertices == d.freeVertexCount());
  CHECK(built->report.minDihedralDeg > 3.0);
  CHECK(test::areaOf(d, {BoundaryTag::Kind::Skin, 0}) ==
        Approx(4 * std::numbers::pi * 0.01).epsilon(0.01));
  CHECK(test::areaOf(d, {BoundaryTag::Kind::Bone, 0}) ==
        Approx(4 * std::numbers::pi * 0.0009).epsilon(0.02));
  CHECK(d.boneNames == std::vector<std::string>{"bone"});
  CHECK_FALSE(built->report.fallback);
}

TEST_CASE("obstacles and cavities that are left out are not counted as bones") {
  DomainInput input = ballInBall();
  input.obstacles = {named(test::sphere({1, 0, 0}, 0.01, 2), "stone")};
  input.cavities = {named(test::sphere({-1, 0, 0}, 0.01, 2), "sinus")};
  const auto without = build(input, options(5000));
  REQUIRE(without);
  CHECK(without->report.bonesUsed == 1);
  CHECK(without->report.bonesLeftOut == 0);

  input.bones.push_back(named(test::sphere({0, 1, 0}, 0.01, 2), "far"));
  const auto one = build(input, options(5000));
  REQUIRE(one);
  CHECK(one->report.bonesUsed == 1);
  CHECK(one->report.bonesLeftOut == 1);
}

TEST_CASE("the same input gives the same domain to the last bit") {
  const auto a = build(ballInBall(), options(8000));
  const auto b = build(ballInBall(), options(8000));
  REQUIRE(a);
  REQUIRE(b);
  CHECK(a->domain.mesh.V == b->domain.mesh.V);
  CHECK(a->domain.mesh.T == b->domain.mesh.T);
  CHECK(a->domain.boundaryF == b->domain.boundaryF);
}

TEST_CASE("a box cut in half: plane vertices lie on the plane, the plane is no skin") {
  DomainInput input;
  input.skin = named(test::box({-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}), "skin");
  input.bones = {named(test::box({-0.02, -0.02, -0.02}, {0.02, 0.02, 0.02}), "bone")};
  input.cutPlanes = {{"median", {0, 0, 0}, {0, 1, 0}}};
  const auto built = build(input, options(10000));
  REQUIRE(built);
  test::requireSound(built->domain);
  CHECK(built->domain.volume == Approx(0.004 - 0.000032).epsilon(1e-6));
  CHECK(test::farthestFromPlane(built->domain, 0, input.cutPlanes[0]) == 0.0);
  CHECK(test::areaOf(built->domain, {BoundaryTag::Kind::CutPlane, 0}) ==
        Approx(0.04 - 0.0016).epsilon(1e-6));
  CHECK(built->domain.cutPlaneNames == std::vector<std::string>{"median"});
}

TEST_CASE("tets are small where small ones are wanted") {
  DomainInput input = ballInBall();
  for (int i = 0; i <= 20; ++i) {
    for (const double y : {0.056, 0.06, 0.064})
      input.lengths.push_back({{-0.05 + 0.005 * i, y, 0.0}, 0.002});
  }
  const auto built = build(input, options(40000));
  REQUIRE(built);
  test::requireSound(built->domain);
  const auto& m = built->domain.mesh;
  const Eigen::VectorXd h = mesh::meanEdgeLengths(m);
  double near = 0.0, far = 0.0;
  int nearCount = 0, farCount = 0;
  for (Eigen::Index t = 0; t < m.T.rows(); ++t) {
    Vector3 middle = Vector3::Zero();
    for (int k = 0; k < 4; ++k) middle += 0.25 * m.V.row(m.T(t, k)).transpose();
    const double away = std::hypot(middle.y() - 0.06, middle.z());
    if (std::abs(middle.x()) < 0.05 && away < 0.004) {
      near += h[t];
      ++nearCount;
    } else if (away > 0.06) {
      far += h[t];
      ++farCount;
    }
  }
  REQUIRE(nearCount > 0);
  REQUIRE(farCount > 0);
  CHECK(near / nearCount < 0.5 * far / farCount);
}

TEST_CASE("bones in any state: inside out, overlapping, poking out") {
  DomainInput input;
  input.skin = named(test::sphere({0, 0, 0}, 0.1, 4), "skin");
  auto insideOut = named(test::sphere({-0.04, 0, 0}, 0.02, 3), "inside-out");
  insideOut.F.col(1).swap(insideOut.F.col(2));
  input.bones = {insideOut, named(test::sphere({0.03, 0, 0}, 0.02, 3), "a"),
                 named(test::sphere({0.055, 0, 0}, 0.015, 3), "b"),
                 named(test::sphere({0, 0, 0.095}, 0.02, 3), "claw")};
  const auto built = build(input, options(30000));
  REQUIRE(built);
  test::requireSound(built->domain);
  CHECK(built->report.maxDeviation <= built->report.tolerance);
  for (int bone = 0; bone < 4; ++bone) {
    CHECK(test::areaOf(built->domain, {BoundaryTag::Kind::Bone, bone}) > 0.0);
  }
  CHECK(test::hasFinding(built->report.findings, "united"));
  CHECK(test::hasFinding(built->report.findings, "pokes-out"));
}

TEST_CASE("a skin and a bone that cut themselves: a sound domain, and it is told where") {
  // Balls through one another, as one surface each
  const auto pair = [](const Vector3& a, const Vector3& b, double radius, const char* name) {
    mesh::SurfaceMesh out =
        mesh::joined({test::sphere(a, radius, 3), test::sphere(b, radius, 3)}, name);
    out.parts.clear();
    return out;
  };
  DomainInput input;
  input.skin = pair({0, 0, 0}, {0.08, 0.011, 0.007}, 0.1, "skin");
  input.bones = {pair({0, 0, 0}, {0.03, 0.002, 0.003}, 0.03, "bone")};
  const auto built = build(input, options(8000));
  REQUIRE(built);
  test::requireSound(built->domain);
  CHECK(built->report.mesher == "TetGen");
  CHECK(built->report.wraps == 0);
  // Two balls of radius r, their centres d apart: less the lens
  const auto united = [](double r, double d) {
    const double lens = std::numbers::pi * (4 * r + d) * std::pow(2 * r - d, 2) / 12;
    return 8.0 / 3.0 * std::numbers::pi * r * r * r - lens;
  };
  CHECK(built->report.volume == Approx(united(0.1, Vector3(0.08, 0.011, 0.007).norm()) -
                                       united(0.03, Vector3(0.03, 0.002, 0.003).norm()))
                                    .epsilon(0.02));
  int told = 0;
  for (const Finding& f : built->report.findings) {
    if (f.kind != "self-intersections") continue;
    ++told;
    CHECK(f.severity == Severity::Repaired);
    CHECK(f.point.has_value());
  }
  CHECK(told == 2);
}

TEST_CASE("bones a hair apart neither merge nor cross") {
  DomainInput input;
  input.skin = named(test::sphere({0, 0, 0}, 0.1, 4), "skin");
  input.bones = {named(test::sphere({-0.02, 0, 0}, 0.0199, 4), "a"),
                 named(test::sphere({0.02, 0, 0}, 0.02, 4), "b")};
  const auto built = build(input, options(30000));
  REQUIRE(built);
  test::requireSound(built->domain);
  CHECK_FALSE(built->report.fallback);
  CHECK(built->report.maxDeviation <= built->report.tolerance);
}

TEST_CASE("what cannot be a domain is an error with a code of its own") {
  const DomainInput good = ballInBall();
  SECTION("bones outside the skin") {
    DomainInput input = good;
    input.bones = {named(test::sphere({1, 0, 0}, 0.03, 3), "far")};
    CHECK(codeOf(build(input, options(5000))) == ErrorCode::BonesOutsideSkin);
  }
  SECTION("a skin with a large hole") {
    DomainInput input = good;
    input.skin.F.conservativeResize(input.skin.F.rows() / 2, 3);
    CHECK(codeOf(build(input, options(5000))) == ErrorCode::SkinNotClosed);
  }
  SECTION("a skin without faces") {
    DomainInput input = good;
    input.skin.F.resize(0, 3);
    CHECK(codeOf(build(input, options(5000))) == ErrorCode::MeshWithoutFaces);
  }
  SECTION("a vertex that is no number") {
    DomainInput input = good;
    input.skin.V(3, 1) = std::nan("");
    CHECK(codeOf(build(input, options(5000))) == ErrorCode::NonFiniteVertex);
  }
  SECTION("a cut plane beyond everything") {
    DomainInput input = good;
    input.cutPlanes = {{"far", {5, 0, 0}, {1, 0, 0}}};
    CHECK(codeOf(build(input, options(5000))) == ErrorCode::EmptyDomain);
  }
  SECTION("a part without skin") {
    // A bone shell around most of the tissue
    DomainInput input = good;
    auto shell = test::sphere({0, 0, 0}, 0.095, 4);
    auto inner = test::sphere({0, 0, 0}, 0.09, 4);
    inner.F.col(1).swap(inner.F.col(2));
    input.bones = {mesh::joined({shell, inner}, "shell")};
    CHECK(codeOf(build(input, options(5000))) == ErrorCode::ComponentWithoutSkin);
  }
  SECTION("settings without sense") {
    DomainOptions o = options(5000);
    o.surfaceToleranceRel = 0.0;
    CHECK(codeOf(build(good, o)) == ErrorCode::ValueOutOfRange);
  }
  SECTION("cancelled") {
    RunContext run;
    run.cancel();
    CHECK(codeOf(buildDomain(good, options(5000), run)) == ErrorCode::Cancelled);
  }
}

TEST_CASE("the cache gives the same domain back, and is made anew where it is damaged") {
  const test::TempFolder folder;
  const char* before = std::getenv("ECORCHE_CACHE");
  const std::string old = before ? before : "";
  setenv("ECORCHE_CACHE", folder.path().c_str(), 1);
  DomainOptions o = options(5000);
  o.useCache = true;
  const auto made = build(ballInBall(), o);
  REQUIRE(made);
  CHECK_FALSE(made->report.fromCache);
  const auto loaded = build(ballInBall(), o);
  REQUIRE(loaded);
  CHECK(loaded->report.fromCache);
  CHECK(loaded->domain.mesh.V == made->domain.mesh.V);
  CHECK(loaded->domain.mesh.T == made->domain.mesh.T);
  CHECK(loaded->domain.neighbours == made->domain.neighbours);
  CHECK(loaded->domain.boundaryTag == made->domain.boundaryTag);
  CHECK(loaded->domain.onSkin == made->domain.onSkin);
  CHECK(loaded->domain.boneNames == made->domain.boneNames);
  CHECK(loaded->report.findings.size() == made->report.findings.size());
  CHECK(loaded->report.maxDeviation == made->report.maxDeviation);

  // Another option, another domain
  DomainOptions finer = o;
  finer.tets = 6000;
  const auto other = build(ballInBall(), finer);
  REQUIRE(other);
  CHECK_FALSE(other->report.fromCache);

  for (const auto& entry : std::filesystem::directory_iterator(folder.path() / "domains")) {
    // One byte in the middle
    std::fstream file(entry.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(entry.file_size() / 2));
    const auto byte = static_cast<char>(file.get() ^ 0x5a);
    file.seekp(static_cast<std::streamoff>(entry.file_size() / 2));
    file.put(byte);
  }
  const auto remade = build(ballInBall(), o);
  REQUIRE(remade);
  CHECK_FALSE(remade->report.fromCache);
  CHECK(test::hasFinding(remade->report.findings, "cache-damaged"));
  CHECK(remade->domain.mesh.V == made->domain.mesh.V);
  if (before) {
    setenv("ECORCHE_CACHE", old.c_str(), 1);
  } else {
    unsetenv("ECORCHE_CACHE");
  }
}
