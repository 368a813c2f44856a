#include <ecorche/mesh/outer_hull.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/uncross.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <random>

#include "mesh/repairs.h"
#include "support/shapes.h"

using namespace ecorche;
using namespace ecorche::mesh;

namespace {

std::optional<SurfaceMesh> hullOf(const SurfaceMesh& mesh) {
  RunContext run;
  return outerHull(mesh, run);
}

/// A ball with one vertex pushed through its far side, and beyond: a fold turned inside out.
SurfaceMesh pierced() {
  SurfaceMesh ball = test::sphere({0, 0, 0}, 1.0, 3);
  Eigen::Index top = 0;
  ball.V.col(2).maxCoeff(&top);
  ball.V.row(top) << 0.013, 0.021, -1.4;
  return ball;
}

}  // namespace

TEST_CASE("an outer hull of one ball in another is the outer one") {
  const auto outer = test::sphere({0, 0, 0}, 1.0, 3);
  const auto hull = hullOf(onePart({outer, test::sphere({0.1, 0, 0}, 0.4, 2)}));
  REQUIRE(hull);
  CHECK(hull->F.rows() == outer.F.rows());
  CHECK(volumeOf(*hull) == Approx(volumeOf(outer)).epsilon(1e-12));
}

TEST_CASE("an outer hull keeps cavities") {
  auto inner = test::sphere({0.1, 0, 0}, 0.4, 2);
  inner.F.col(1).swap(inner.F.col(2));
  const auto outer = test::sphere({0, 0, 0}, 1.0, 3);
  const auto hull = hullOf(onePart({outer, inner}));
  REQUIRE(hull);
  CHECK(volumeOf(*hull) == Approx(volumeOf(outer) + volumeOf(inner)).epsilon(1e-12));
}

TEST_CASE("two boxes that cross: the volume of their union, to rounding") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shift(-0.6, 0.6);
  for (int trial = 0; trial < 50; ++trial) {
    const Vector3 by(shift(random), shift(random), shift(random));
    const auto a = test::box({0, 0, 0}, {1, 1, 1});
    const auto b = test::box(by, by + Vector3(1.1, 0.9, 1.2));
    const Vector3 overlap =
        (Vector3(1, 1, 1).cwiseMin(by + Vector3(1.1, 0.9, 1.2)) - Vector3::Zero().cwiseMax(by))
            .cwiseMax(0.0);
    INFO("shifted by " << by.transpose());
    const auto hull = hullOf(onePart({a, b}));
    REQUIRE(hull);
    CHECK(isUncrossed(*hull));
    CHECK(volumeOf(*hull) == Approx(1.0 + 1.1 * 0.9 * 1.2 - overlap.prod()).epsilon(1e-12));
  }
}

TEST_CASE("balls pushed into one another: nothing of the hull lies inside a ball or off both") {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> shift(-0.8, 0.8);
  for (int trial = 0; trial < 10; ++trial) {
    const auto a = test::sphere({0, 0, 0}, 0.7, 2);
    const auto b = test::sphere({shift(random), shift(random), shift(random)}, 0.5, 2);
    const auto hull = hullOf(onePart({a, b}));
    REQUIRE(hull);
    CHECK(isUncrossed(*hull));
    const SurfaceQuery inA(a);
    const SurfaceQuery inB(b);
    for (Eigen::Index v = 0; v < hull->V.rows(); ++v) {
      const Vector3 p = hull->V.row(v).transpose();
      const double da = inA.signedDistance(p);
      const double db = inB.signedDistance(p);
      CHECK(std::min(da, db) == Approx(0.0).margin(1e-12));
    }
  }
}

TEST_CASE("a fold turned inside out goes") {
  const SurfaceMesh mesh = pierced();
  REQUIRE_FALSE(isUncrossed(mesh));
  const auto hull = hullOf(mesh);
  REQUIRE(hull);
  CHECK(isUncrossed(*hull));
  // The ball with a funnel in its top; what stuck out below was inside out
  CHECK(volumeOf(*hull) > 0.9 * volumeOf(mesh));
  CHECK(boundingBox(*hull).lo.z() > -1.001);
}

TEST_CASE("uncrossing touches nothing far from the crossing") {
  SurfaceMesh mesh = test::sphere({0, 0, 0}, 1.0, 4);
  Eigen::Index top = 0;
  mesh.V.col(2).maxCoeff(&top);
  // One vertex dragged over its neighbours: faces that dip under the ball and come out again
  mesh.V.row(top) << 0.3, 0.02, 0.957;
  REQUIRE_FALSE(isUncrossed(mesh));
  const auto smooth = uncross(mesh);
  REQUIRE(smooth);
  CHECK(isUncrossed(*smooth));
  const SurfaceQuery before(mesh);
  for (Eigen::Index v = 0; v < smooth->V.rows(); ++v) {
    if (smooth->V(v, 2) < 0.5) CHECK(before.distance(smooth->V.row(v).transpose()) < 1e-12);
  }
  CHECK(volumeOf(*smooth) == Approx(volumeOf(mesh)).epsilon(0.02));
}

TEST_CASE("sheets that meet in a point nearer than doubles can tell: a hull, or none") {
  // Boxes with a face through one point each, but for rounding: the crossings around it are
  // triangles without an area
  std::mt19937 random(3);
  std::normal_distribution<double> any;
  for (int trial = 0; trial < 12; ++trial) {
    INFO("trial " << trial);
    std::vector<SurfaceMesh> boxes;
    for (int b = 0; b < 5; ++b) {
      const Eigen::Quaterniond turn(any(random), any(random), any(random), any(random));
      SurfaceMesh box = test::box({-1, -1.1, 0}, {1.2, 1, 1.3});
      for (Eigen::Index v = 0; v < box.V.rows(); ++v) {
        box.V.row(v) =
            (turn.normalized() * box.V.row(v).transpose() + Vector3(700, 900, 800)).transpose();
      }
      boxes.push_back(box);
    }
    const SurfaceMesh all = onePart(boxes);
    std::optional<SurfaceMesh> hull;
    REQUIRE_NOTHROW(hull = hullOf(all));
    if (hull) CHECK(isUncrossed(*hull));
  }
}

TEST_CASE("no outer hull after a cancel") {
  RunContext run;
  run.cancel();
  CHECK_FALSE(outerHull(test::sphere({0, 0, 0}, 1.0, 2), run));
}
