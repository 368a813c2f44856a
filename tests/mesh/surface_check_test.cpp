#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_topology.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <numbers>
#include <random>

#include "support/paths.h"
#include "support/shapes.h"

using namespace ecorche;
using namespace ecorche::mesh;

namespace {

SurfaceCheck checkAll(const SurfaceMesh& m) { return checkSurface(m, {.selfIntersections = true}); }

SurfaceMesh withoutFaces(SurfaceMesh m, const std::vector<int>& gone) {
  Triangles F(m.F.rows() - Eigen::Index(gone.size()), 3);
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
    if (std::ranges::find(gone, int(f)) == gone.end()) F.row(kept++) = m.F.row(f);
  }
  m.F = F;
  return m;
}

const Finding* found(const SurfaceCheck& check, const std::string& kind) {
  const auto at = std::ranges::find(check.findings, kind, &Finding::kind);
  return at == check.findings.end() ? nullptr : &*at;
}

}  // namespace

TEST_CASE("sound surfaces have nothing wrong, and their measures are those of geometry") {
  const SurfaceCheck box = checkAll(test::box({1, 2, 3}, {3, 5, 7}));
  CHECK(box.isSound());
  CHECK(box.findings.empty());
  REQUIRE(box.components.size() == 1);
  CHECK(box.components[0].volume == Approx(24));
  CHECK(box.components[0].area == Approx(52));
  CHECK(box.components[0].closed);
  CHECK(box.components[0].genus == 0);
  CHECK(box.selfIntersections == 0);

  const SurfaceMesh ring = test::torus(3, 1, 60, 40);
  const SurfaceCheck torus = checkAll(ring);
  CHECK(torus.isSound());
  CHECK(torus.findings.empty());
  CHECK(torus.components[0].genus == 1);
  CHECK(torus.components[0].volume ==
        Approx(2 * std::numbers::pi * std::numbers::pi * 3).epsilon(0.02));
  CHECK(isClosed(ring.F));
  CHECK(isManifold(ring.F));
  CHECK(isOriented(ring.F));
}

TEST_CASE("a hole is found with its place and its extent") {
  const SurfaceMesh m = withoutFaces(test::box({0, 0, 0}, {1, 1, 1}), {2, 3});  // the top
  const SurfaceCheck check = checkAll(m);
  CHECK_FALSE(check.isSound());
  CHECK(check.borderEdges == 4);
  REQUIRE(check.holes.size() == 1);
  CHECK(check.holes[0].extent == Approx(std::numbers::sqrt2));
  CHECK(check.holes[0].perimeter == Approx(4));
  CHECK((check.holes[0].place - Vector3(0.5, 0.5, 1)).norm() < 1e-12);
  CHECK_FALSE(check.components[0].closed);
  CHECK_FALSE(check.components[0].genus);
  REQUIRE(found(check, "hole") != nullptr);
  CHECK(found(check, "hole")->object == "box");
  CHECK_FALSE(isClosed(m.F));
  CHECK(isManifold(m.F));
  CHECK(isOriented(m.F));

  // The larger hole comes first; borders that touch in a vertex are one
  const SurfaceMesh larger = withoutFaces(test::box({0, 0, 0}, {2, 2, 1}), {2});
  const SurfaceCheck two = checkAll(joined({m, larger}, "two"));
  REQUIRE(two.holes.size() == 2);
  CHECK(two.holes[0].edges == 3);
  CHECK(two.holes[1].edges == 4);
  CHECK(checkAll(withoutFaces(test::box({0, 0, 0}, {1, 1, 1}), {2, 6})).holes.size() == 1);
}

TEST_CASE("each fault is counted, placed and named") {
  SurfaceMesh m = test::box({0, 0, 0}, {1, 1, 1});
  SECTION("a vertex that is no number") {
    m.V(5, 1) = std::nan("");
    const auto check = checkAll(m);
    CHECK(check.nonFiniteVertices == 1);
    CHECK(found(check, "non-finite-vertex")->severity == Severity::Error);
    CHECK_FALSE(check.isSound());
  }
  SECTION("vertices nobody uses") {
    m.V.conservativeResize(10, 3);
    m.V.bottomRows(2).setConstant(7);
    const auto check = checkAll(m);
    CHECK(check.unusedVertices == 2);
    CHECK(check.duplicateVertices == 0);
    CHECK(check.isSound());
    CHECK(found(check, "unused-vertices")->point->x() == 7);
  }
  SECTION("a cut along an edge") {
    m.V.conservativeResize(9, 3);
    m.V.row(8) = m.V.row(0);
    m.F(0, 0) = 8;
    const auto check = checkAll(m);
    CHECK(check.duplicateVertices == 1);
    CHECK(check.borderEdges == 4);
    CHECK(found(check, "duplicate-vertices")->point->norm() == 0);
  }
  SECTION("faces without area") {
    m.F.conservativeResize(14, 3);
    m.F.row(12) << 0, 0, 1;
    m.V.conservativeResize(9, 3);
    m.V.row(8) << 0.5, 0, 0;
    m.F.row(13) << 0, 8, 1;
    const auto check = checkAll(m);
    CHECK(check.degenerateFaces == 2);
    CHECK_FALSE(check.isSound());
  }
  SECTION("a face twice") {
    m.F.conservativeResize(13, 3);
    m.F.row(12) << 2, 1, 0;
    const auto check = checkAll(m);
    CHECK(check.duplicateFaces == 1);
    CHECK(check.nonManifoldEdges == 3);
    CHECK_FALSE(isManifold(m.F));
  }
  SECTION("a face turned over") {
    std::swap(m.F(4, 0), m.F(4, 1));
    const auto check = checkAll(m);
    CHECK(check.inconsistentEdges == 3);
    CHECK_FALSE(check.components[0].closed);
    CHECK_FALSE(isOriented(m.F));
    CHECK(isClosed(m.F));
  }
  SECTION("inside out") {
    m.F.col(1).swap(m.F.col(2));
    const auto check = checkAll(m);
    CHECK(check.components[0].inward);
    CHECK(found(check, "inward")->size == Approx(1));
    CHECK(check.isSound());
  }
  SECTION("two boxes that share a corner") {
    SurfaceMesh two = joined({m, test::box({1, 1, 1}, {2, 2, 2})}, "two");
    for (auto& v : two.F.reshaped()) v = v == 8 ? 7 : v;
    const auto check = checkAll(two);
    CHECK(check.nonManifoldVertices == 1);
    CHECK((*found(check, "non-manifold-vertices")->point - Vector3(1, 1, 1)).norm() == 0);
    CHECK(check.components.size() == 2);
    CHECK(check.components[0].genus == 0);
    CHECK(check.components[1].genus == 0);
    CHECK(check.selfIntersections == 0);
    CHECK_FALSE(isManifold(two.F));
  }
  SECTION("two boxes that share an edge") {
    SurfaceMesh two = joined({m, test::box({1, 1, 0}, {2, 2, 1})}, "two");
    for (auto& v : two.F.reshaped()) v = v == 8 ? 3 : v == 12 ? 7 : v;
    const auto check = checkAll(two);
    CHECK(check.nonManifoldEdges == 1);
    CHECK(check.components.size() == 1);
    CHECK(check.components[0].closed);
    CHECK(isClosed(two.F));
    CHECK_FALSE(isManifold(two.F));
  }
}

TEST_CASE("faces that cut each other are found, neighbours are not") {
  const SurfaceMesh a = test::box({0, 0, 0}, {1, 1, 1});
  CHECK(checkAll(joined({a, test::box({0.5, 0.5, 0.5}, {1.5, 1.5, 1.5})}, "overlap"))
            .selfIntersections > 0);
  CHECK(checkAll(joined({a, test::box({2, 2, 2}, {3, 3, 3})}, "apart")).selfIntersections == 0);
  CHECK(checkAll(joined({a, test::box({0.2, 0.2, 0.2}, {0.8, 0.8, 0.8})}, "nested"))
            .selfIntersections == 0);

  // A vertex pulled through the opposite wall: neighbours by edge and vertex are at fault
  SurfaceMesh pulled = test::sphere({0, 0, 0}, 1, 3);
  CHECK(checkAll(pulled).selfIntersections == 0);
  pulled.V.row(0) *= -1.5;
  const auto pairs = selfIntersections(pulled.V, pulled.F);
  CHECK_FALSE(pairs.empty());
  CHECK(std::ranges::is_sorted(pairs));

  // A strip folded flat on itself: two faces with an edge in common
  SurfaceMesh fold;
  fold.V.resize(4, 3);
  fold.V << 0, 0, 0, 1, 0, 0, 0.3, 1, 0, 0.4, 0.5, 0;
  fold.F.resize(2, 3);
  fold.F << 0, 1, 2, 1, 0, 3;
  CHECK(checkAll(fold).selfIntersections == 1);
  fold.V(3, 1) = -0.5;
  CHECK(checkAll(fold).selfIntersections == 0);
}

TEST_CASE("turning, moving and renumbering a surface changes no count") {
  SurfaceMesh m = joined(
      {withoutFaces(test::sphere({0, 0, 0}, 1, 2), {0, 1, 17}), test::torus(4, 1, 12, 8)}, "m");
  const auto before = checkAll(m);
  std::mt19937 random(3);
  std::vector<std::int32_t> order(std::size_t(m.V.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), random);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
  SurfaceMesh moved = m;
  for (Eigen::Index v = 0; v < m.V.rows(); ++v) {
    moved.V.row(order[std::size_t(v)]) = (turn * m.V.row(v).transpose()).transpose().array() + 10;
  }
  moved.F = m.F.unaryExpr([&](std::int32_t v) { return order[std::size_t(v)]; });
  moved.F = moved.F.colwise().reverse().eval();
  const auto after = checkAll(moved);
  CHECK(after.borderEdges == before.borderEdges);
  CHECK(after.holes.size() == before.holes.size());
  CHECK(after.components.size() == before.components.size());
  CHECK(after.components[0].genus == 1);
  CHECK(after.components[0].volume == Approx(before.components[1].volume));
}

TEST_CASE("the dog is as it is described: a sound skin, 170 sound bones of 172") {
  if (!test::haveData("dog")) return;
  RunContext run;
  const auto skin = readMesh(test::dataFolder() / "dog/SKINbody.stl", {}, run);
  REQUIRE(skin);
  const auto check = checkAll(*skin);
  CHECK(check.isSound());
  CHECK(check.selfIntersections == 0);
  CHECK(check.components.size() == 1);
  CHECK(check.components[0].genus == 0);

  std::vector<std::string> unsound;
  for (const auto& entry : std::filesystem::directory_iterator(test::dataFolder() / "dog/bones")) {
    const auto bone = readMesh(entry.path(), {}, run);
    REQUIRE(bone);
    if (!checkSurface(*bone).isSound()) unsound.push_back(bone->name);
  }
  std::ranges::sort(unsound);
  CHECK(unsound == std::vector<std::string>{"BONERibcage", "BONEXiphoid_cartilage"});
}

TEST_CASE("mirrored leg bones face inward") {
  if (!test::haveData("bmf_bones")) return;
  RunContext run;
  int inward = 0;
  for (const auto& entry : std::filesystem::directory_iterator(test::dataFolder() / "bmf_bones")) {
    if (entry.path().extension() != ".obj") continue;
    const auto bone = readMesh(entry.path(), {}, run);
    REQUIRE(bone);
    const auto check = checkSurface(*bone);
    for (const auto& c : check.components) inward += c.inward ? 1 : 0;
  }
  CHECK(inward > 0);
}

TEST_CASE("a triangle on its own is no hole, and thousands of borders are no list") {
  SurfaceMesh m = test::sphere({0, 0, 0}, 1, 3);
  m.V.conservativeResize(m.V.rows() + 3, 3);
  m.V.bottomRows(3) << 3, 3, 3, 3.5, 3, 3, 3, 3.5, 3;
  const auto last = static_cast<std::int32_t>(m.V.rows());
  m.F.conservativeResize(m.F.rows() + 1, 3);
  m.F.bottomRows(1) << last - 3, last - 2, last - 1;
  const SurfaceCheck stray = checkSurface(m);
  REQUIRE(stray.holes.size() == 1);
  CHECK(stray.components[std::size_t(stray.holes[0].piece)].faces == 1);
  CHECK(std::ranges::count(stray.findings, "sheet", &Finding::kind) == 1);
  CHECK(std::ranges::count(stray.findings, "hole", &Finding::kind) == 0);
  // Where there is nothing that it could stand beside
  const SurfaceCheck alone = checkSurface(compacted({.V = m.V, .F = m.F.bottomRows(1)}));
  CHECK(std::ranges::count(alone.findings, "lone-face", &Finding::kind) == 1);

  // Every second pair of faces apart from the rest
  SurfaceMesh open = test::torus(3, 1, 60, 40);
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < open.F.rows(); ++f) {
    if (f / 2 % 2 == 0 && f / 80 % 2 == 0) open.F.row(kept++) = open.F.row(f).eval();
  }
  open.F.conservativeResize(kept, 3);
  const SurfaceCheck many = checkSurface(open);
  CHECK(many.holes.size() > 100);
  CHECK(many.findings.size() < 20);
  CHECK(std::ranges::any_of(many.findings, [&](const Finding& f) {
    return f.message.find(std::to_string(many.holes.size() - 8) + " more borders") == 0;
  }));
}
