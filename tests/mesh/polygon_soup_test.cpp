#include <ecorche/mesh/polygon_soup.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "support/cases.h"

using namespace ecorche::mesh;

namespace {

using Polygon = std::vector<Vector3>;

Vector3 areaVector(const Vector3& a, const Vector3& b, const Vector3& c) {
  return 0.5 * (b - a).cross(c - a);
}

// A triangulation of a flat simple polygon: n − 2 triangles, none turned over, areas add up.
void checkTriangulation(const Polygon& polygon, const Vector3& normal, double smallest = 1e-12) {
  Vector3 whole = Vector3::Zero();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    whole += 0.5 * polygon[k].cross(polygon[(k + 1) % polygon.size()]);
  }
  const auto triangles = triangulatePolygon(polygon);
  CHECK(triangles.size() == polygon.size() - 2);
  Vector3 sum = Vector3::Zero();
  bool turned = false;
  for (const auto& [a, b, c] : triangles) {
    const Vector3 area =
        areaVector(polygon[std::size_t(a)], polygon[std::size_t(b)], polygon[std::size_t(c)]);
    turned = turned || !(area.dot(normal) > smallest);
    sum += area;
  }
  CHECK_FALSE(turned);
  CHECK((sum - whole).norm() < 1e-9 * (1 + whole.norm()));
}

Polygon onPlane(const std::vector<std::pair<double, double>>& flat, const Eigen::Matrix3d& turn) {
  Polygon polygon;
  for (const auto& [x, y] : flat) polygon.push_back(turn * Vector3(x, y, 0) + Vector3(5, -3, 2));
  return polygon;
}

}  // namespace

TEST_CASE("concave polygons are cut inside, whatever their plane and first corner") {
  const std::vector<std::vector<std::pair<double, double>>> shapes = {
      {{0, 0}, {2, 0}, {0.5, 0.5}, {0, 2}},                              // arrow: concave quad
      {{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}},  // U
      {{0, 0}, {1, 0}, {2, 0}, {2, 2}, {1, 2}, {0, 2}},                  // straight corners
      {{0, 0}, {4, 0}, {4, 1}, {1, 1}, {1, 3}, {4, 3}, {4, 4}, {0, 4}},  // C
      {{0, 0},
       {4, 0},
       {4, 4},
       {0, 4},
       {0, 0},
       {1, 1},
       {1, 3},
       {3, 3},
       {3, 1},
       {1, 1}}};  // keyhole: square with a hole
  std::mt19937 random(1);
  std::normal_distribution<double> g;
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    for (int trial = 0; trial < 20; ++trial) {
      auto flat = shapes[s];
      std::rotate(flat.begin(), flat.begin() + trial % int(flat.size()), flat.end());
      const Eigen::Matrix3d turn = Eigen::Quaterniond(g(random), g(random), g(random), g(random))
                                       .normalized()
                                       .toRotationMatrix();
      INFO("shape " << s << " trial " << trial);
      checkTriangulation(onPlane(flat, turn), turn.col(2));
    }
  }
}

TEST_CASE("stars, spirals and a random simple polygon of many corners") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> radius(0.2, 1.0);
  for (const int n : {5, 6, 17, 100, 1000}) {
    std::vector<std::pair<double, double>> star;
    for (int k = 0; k < n; ++k) {
      const double a = 2 * std::numbers::pi * k / n;
      const double r = radius(random);
      star.emplace_back(r * std::cos(a), r * std::sin(a));
    }
    INFO("corners " << n);
    checkTriangulation(onPlane(star, Eigen::Matrix3d::Identity()), Vector3::UnitZ(), 0.0);
  }
}

// What is not quick here takes hours: the suite's own time limit is the judge
TEST_CASE("polygons that are no polygons still end, in time") {
  std::mt19937 random(3);
  std::normal_distribution<double> g;
  for (const std::size_t n : {5, 50, ecorche::test::kSanitized ? 4000 : 20000}) {
    Polygon tangle;
    for (std::size_t k = 0; k < n; ++k) tangle.emplace_back(g(random), g(random), g(random));
    CHECK(triangulatePolygon(tangle).size() == n - 2);
    CHECK(triangulatePolygon(Polygon(n, Vector3(1, 2, 3))).size() == n - 2);
  }
  CHECK(triangulatePolygon({{0, 0, 0}, {1, 0, 0}}).empty());
}

TEST_CASE("a bent quad is folded along its shorter diagonal") {
  const auto cut = triangulatePolygon({{0, 0, 0}, {2, 0, 0.1}, {2.2, 1, 0}, {0, 1, 0.1}});
  REQUIRE(cut.size() == 2);
  CHECK(cut[0] == std::array<std::int32_t, 3>{1, 2, 3});
}
