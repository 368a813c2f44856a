// What lies beside a skin and is no part of it: hair cards, crumbs, triangles on their own.
#include <ecorche/mesh/face_repair.h>
#include <ecorche/mesh/surface_topology.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "mesh/repairs.h"

using namespace ecorche;
using namespace ecorche::mesh;

namespace {

// A grid of 2n faces from a corner along two sides, bent up in the middle.
SurfaceMesh sheet(const Vector3& corner, const Vector3& u, const Vector3& v, double bend, int n) {
  SurfaceMesh m;
  m.V.resize(2 * (n + 1), 3);
  m.F.resize(2 * n, 3);
  for (int i = 0; i <= n; ++i) {
    const double t = double(i) / n;
    const Vector3 p = corner + t * u + 4 * t * (1 - t) * bend * u.cross(v).normalized();
    m.V.row(2 * i) = p.transpose();
    m.V.row(2 * i + 1) = (p + v).transpose();
    if (i == n) break;
    m.F.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 3;
    m.F.row(2 * i + 1) << 2 * i, 2 * i + 3, 2 * i + 1;
  }
  return m;
}

SurfaceMesh named(SurfaceMesh m, const char* name) {
  m.name = name;
  return m;
}

// Faces with their middle below this height.
SurfaceMesh below(SurfaceMesh m, double z) {
  for (Eigen::Index f = m.F.rows() - 1; f >= 0; --f) {
    if ((m.V(m.F(f, 0), 2) + m.V(m.F(f, 1), 2) + m.V(m.F(f, 2), 2)) / 3 > z) dropFace(m, f);
  }
  return m;
}

}  // namespace

TEST_CASE("a triangle on its own is no hole: a bone keeps it open, a skin leaves it out") {
  const auto withStray = [](SurfaceMesh m) {
    const auto first = static_cast<std::int32_t>(m.V.rows());
    m.V.conservativeResize(first + 3, 3);
    m.V.bottomRows(3) << 3, 3, 3, 3.5, 3, 3, 3, 3.5, 3;
    addFace(m, first, first + 1, first + 2);
    return m;
  };
  for (const double holeRel : {0.05, 0.5, std::numeric_limits<double>::infinity()}) {
    const auto bone = repair(withStray(ball()), {.holeRel = holeRel});
    REQUIRE(bone);
    CHECK_FALSE(repaired(*bone, "hole"));
    CHECK(checkSurface(bone->mesh).holes.size() == 1);
    const auto skin = repair(withStray(ball()), {.holeRel = holeRel, .mustClose = true});
    checkWhole(skin, volumeOf(ball()));
    REQUIRE(repaired(*skin, "sheet"));
    CHECK(findingOf(*skin, "sheet")->point->isApprox(Vector3(3.25, 3.25, 3), 1e-9));
  }
}

TEST_CASE("hair cards beside a skin are left out by name, flat or bent, crossing it or not") {
  const Vector3 top(0.1, 0.2, 1.2);  // where they share a vertex
  const SurfaceMesh flat = named(sheet(top, {0.6, 0, 0.5}, {0, 0.2, 0}, 0, 4), "fringe");
  const SurfaceMesh bent = named(sheet(top, {0, 0.6, -0.5}, {0.1, 0, 0}, 0.1, 6), "tuft");
  const SurfaceMesh strand = named(sheet(top, {0, -0.9, 0.1}, {0.01, 0.003, 0}, 0.4, 12), "strand");
  const auto whole =
      repair(joined({named(ball(), "head"), flat, bent, strand}, "skin"), {.mustClose = true});
  checkWhole(whole, volumeOf(ball()));
  REQUIRE(findingOf(*whole, "sheet"));
  const std::string& said = findingOf(*whole, "sheet")->message;
  CHECK(said.find("3 open sheets") != std::string::npos);
  for (const char* name : {"fringe", "tuft", "strand"}) CHECK(said.find(name) != std::string::npos);
  CHECK(said.find("head") == std::string::npos);
  const auto seen = checkSurface(joined({named(ball(), "head"), flat, bent, strand}, "skin"));
  CHECK(std::ranges::count(seen.findings, "sheet", &Finding::kind) == 1);
  CHECK(std::ranges::count(seen.findings, "hole", &Finding::kind) == 0);

  // Where the head is open too, the hole that is told and filled is the head's alone
  const SurfaceMesh open = joined({named(below(ball(), 1.0), "head"), flat, bent, strand}, "skin");
  const auto refused = repair(open, {.mustClose = true});
  REQUIRE_FALSE(refused);
  CHECK(refused.error().message.find("more;") == std::string::npos);
  CHECK(refused.error().message.find("fill-holes") != std::string::npos);
  const auto filled =
      repair(open, {.holeRel = std::numeric_limits<double>::infinity(), .mustClose = true});
  REQUIRE(filled);
  CHECK(checkSurface(filled->mesh).isSound());
  CHECK(checkSurface(filled->mesh).components.size() == 1);
  CHECK(repaired(*filled, "hole"));
}

TEST_CASE("what belongs to a skin is no sheet: patches cracked off, half a ball, the skin itself") {
  // The cap of a ball, lifted a little: flat, but its border runs along the ball's
  SurfaceMesh cap = ball();
  for (Eigen::Index f = cap.F.rows() - 1; f >= 0; --f) {
    if ((cap.V(cap.F(f, 0), 2) + cap.V(cap.F(f, 1), 2) + cap.V(cap.F(f, 2), 2)) / 3 <= 1.0)
      dropFace(cap, f);
  }
  cap.V.col(2).array() += 0.01;
  const auto cracked = repair(joined({below(ball(), 1.0), cap}, "skin"), {.mustClose = true});
  REQUIRE_FALSE(cracked);
  CHECK(cracked.error().message.find("is cracked along a border") != std::string::npos);

  SurfaceMesh half = below(ball(), 0.3);
  half.V.col(0).array() += 5.0;
  const auto two = repair(joined({ball(), half}, "skin"), {.mustClose = true});
  REQUIRE_FALSE(two);
  CHECK(two.error().message.find("fill-holes") != std::string::npos);

  const auto alone = repair(sheet({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0, 4), {.mustClose = true});
  REQUIRE_FALSE(alone);
  CHECK(alone.error().code == ErrorCode::SkinNotClosed);
}

TEST_CASE("crumbs that touch nothing are no part of a skin, in the air or in the flesh") {
  const SurfaceMesh air = test::sphere({0.1, 0.2, 1.6}, 0.02, 1);
  SurfaceMesh bubble = test::sphere({0.1, 0.2, 0.5}, 0.02, 1);
  bubble.F.col(1).swap(bubble.F.col(2));
  const SurfaceMesh wart = test::sphere({0.1, 0.2, 1.3}, 0.03, 1);  // halfway in the skin
  const auto skin = repair(joined({ball(), air, bubble}, "skin"), {.mustClose = true});
  checkWhole(skin, volumeOf(ball()));
  REQUIRE(repaired(*skin, "speck"));
  CHECK(checkSurface(skin->mesh).components.size() == 1);
  const auto bone = repair(joined({ball(), air, bubble}, "bone"));
  REQUIRE(bone);
  CHECK(checkSurface(bone->mesh).components.size() == 3);
  const auto touching = repair(joined({ball(), wart}, "skin"), {.mustClose = true});
  REQUIRE(touching);
  CHECK(checkSurface(touching->mesh).components.size() == 2);
  // Proofs of a build leave out the same pieces, and no others
  const SurfaceMesh all = joined({ball(), air, bubble, wart}, "skin");
  CHECK(crumbs(all.V, all.F, components(all.F), checkSurface(all).components) ==
        std::vector<char>{0, 1, 1, 0});
}

TEST_CASE("blocks that touch along an edge are cut apart there, and both are whole") {
  const SurfaceMesh a = test::box({0, 0, 0}, {1, 1, 1});
  const SurfaceMesh b = test::box({1, 1, 0}, {2, 2, 1});
  const auto skin = repair(joined({a, b}, "skin"), {.mustClose = true});
  checkWhole(skin, 2.0);
  CHECK(checkSurface(skin->mesh).components.size() == 2);
}
