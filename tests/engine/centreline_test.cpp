// The middle of a muscle whose shape is known.

#include <ecorche/engine/centreline.h>

#include <catch2/catch.hpp>

#include <cmath>

#include "authoring/shapes.h"

using namespace ecorche;
using mesh::Vector3;

namespace {

// Faces of a mesh whose corners all pass
template <class Takes>
mesh::SurfaceMesh facesWhere(const mesh::SurfaceMesh& mesh, const Takes& takes) {
  mesh::SurfaceMesh out = mesh;
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    bool all = true;
    for (int k = 0; k < 3; ++k) all = all && takes(Vector3(mesh.V.row(mesh.F(f, k)).transpose()));
    if (all) out.F.row(count++) = mesh.F.row(f);
  }
  out.F.conservativeResize(count, 3);
  return mesh::compacted(out);
}

constexpr double kHalfTurn = 1.2;  // of the arc to either side [rad]
constexpr double kThick = 0.15;

// A spindle bent along an arc of radius 1 about the origin
Vector3 bent(const Vector3& p) {
  const double angle = kHalfTurn * p.x();
  return (1.0 + kThick * p.y()) * Vector3(std::sin(angle), std::cos(angle), 0.0) +
         kThick * p.z() * Vector3::UnitZ();
}
double angleOf(const Vector3& p) { return std::atan2(p.x(), p.y()); }

}  // namespace

TEST_CASE("the centreline of a bent spindle is its arc") {
  const mesh::SurfaceMesh muscle = test::ball(4, bent);
  const auto from = facesWhere(muscle, [](const Vector3& p) { return angleOf(p) < -1.1; });
  const auto to = facesWhere(muscle, [](const Vector3& p) { return angleOf(p) > 1.1; });
  const auto line = engine::centrelineOf(muscle, from, to);
  REQUIRE(line);
  CHECK(line->inside == Approx(1.0).margin(0.02));
  CHECK(line->radius == Approx(kThick).epsilon(0.05));
  double before = -2.0;
  for (const Vector3& p : line->points) {
    CHECK(std::abs(p.head<2>().norm() - 1.0) < 0.03 * kThick + 0.004);
    CHECK(std::abs(p.z()) < 0.01 * kThick);
    CHECK(angleOf(p) > before);
    before = angleOf(p);
  }
  CHECK(angleOf(line->points.front()) < -1.05);
  CHECK(angleOf(line->points.back()) > 1.05);
}

TEST_CASE("a branch that ends blind does not pull the centreline to it") {
  // A straight spindle with a bump as high as it is thick
  const auto lumpy = [](const Vector3& p) -> Vector3 {
    const double bump = 0.3 * std::exp(-60.0 * (p - Vector3(0, 0, 1)).squaredNorm());
    return {p.x(), kThick * p.y(), kThick * p.z() + bump};
  };
  const mesh::SurfaceMesh muscle = test::ball(5, lumpy);
  const auto from = facesWhere(muscle, [](const Vector3& p) { return p.x() < -0.93; });
  const auto to = facesWhere(muscle, [](const Vector3& p) { return p.x() > 0.93; });
  const auto line = engine::centrelineOf(muscle, from, to);
  REQUIRE(line);
  for (const Vector3& p : line->points) {
    CHECK(std::abs(p.y()) < 0.02);
    CHECK(std::abs(p.z()) < 0.5 * kThick);
  }
}

TEST_CASE("patches on two surfaces have no centreline between them") {
  const auto one = test::ball(2, [](const Vector3& p) -> Vector3 { return p; });
  const auto other =
      test::ball(2, [](const Vector3& p) -> Vector3 { return p + Vector3(5, 0, 0); });
  const auto from = facesWhere(one, [](const Vector3& p) { return p.x() < -0.8; });
  const auto to = facesWhere(other, [](const Vector3& p) { return p.x() > 5.8; });
  CHECK_FALSE(engine::centrelineOf(mesh::joined({one, other}, "two"), from, to));
}
