#include <ecorche/domain/triangle_tree.h>
#include <support/shapes.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <random>

using namespace ecorche;
using mesh::Vector3;

TEST_CASE("the tree answers as asking every triangle would") {
  const auto surface = test::torus(0.3, 0.1, 40, 17);
  const domain::TriangleTree tree(surface.V, surface.F);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-0.5, 0.5);
  for (int i = 0; i < 300; ++i) {
    const Vector3 p(uniform(random), uniform(random), uniform(random));
    double nearest2 = std::numeric_limits<double>::infinity();
    for (Eigen::Index f = 0; f < surface.F.rows(); ++f) {
      const Vector3 q = domain::closestOnTriangle(p, surface.V.row(surface.F(f, 0)).transpose(),
                                                  surface.V.row(surface.F(f, 1)).transpose(),
                                                  surface.V.row(surface.F(f, 2)).transpose());
      nearest2 = std::min(nearest2, (p - q).squaredNorm());
    }
    CHECK(tree.closest(p).distance2 == Approx(nearest2));
    const double distance = std::sqrt(nearest2);
    CHECK(tree.within(p, 1.001 * distance));
    CHECK_FALSE(tree.within(p, 0.999 * distance));
  }
}

TEST_CASE("rays meet the wall that is next") {
  const auto surface = test::sphere(Vector3(0.1, 0.2, 0.3), 1.0, 4);
  const domain::TriangleTree tree(surface.V, surface.F);
  for (const Vector3& direction :
       {Vector3(1, 0, 0), Vector3(0, -1, 0), Vector3(1, 2, -3).normalized().eval()}) {
    const auto hit = tree.firstHit({0.1, 0.2, 0.3}, direction, 0.0, 10.0);
    REQUIRE(hit.has_value());
    CHECK(*hit == Approx(1.0).epsilon(0.01));
  }
  CHECK_FALSE(tree.firstHit({5.0, 0.0, 0.0}, {1, 0, 0}, 0.0, 10.0).has_value());
}

TEST_CASE("a triangle without area is the segment or the point that it is") {
  const Vector3 a(0, 0, 0), b(1, 0, 0);
  CHECK((domain::closestOnTriangle({0.4, 1, 0}, a, b, b) - Vector3(0.4, 0, 0)).norm() < 1e-15);
  CHECK((domain::closestOnTriangle({2, 1, 0}, a, a, b) - b).norm() < 1e-15);
  CHECK((domain::closestOnTriangle({2, 1, 0}, a, a, a) - a).norm() < 1e-15);
}
