#include <ecorche/mesh/spline.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

using namespace ecorche::mesh;

TEST_CASE("a spline passes through its control points, and its tangent is its derivative") {
  const Spline s({{0, 0, 0}, {1, 0.5, 0}, {1.2, 2, 1}, {3, 2, 0}});
  for (std::size_t p = 0; p < 4; ++p) CHECK((s.at(double(p)) - s.points()[p]).norm() < 1e-14);
  for (double u : {0.1, 0.9, 1.3, 1.999, 2.5}) {
    const double h = 1e-6;
    const Vector3 difference = (s.at(u + h) - s.at(u - h)) / (2 * h);
    CHECK((difference - s.derivative(u)).norm() < 1e-7);
  }
}

TEST_CASE("arc length of a straight line is its chord, of a fine circle its angle") {
  const Spline line({{0, 0, 0}, {0.25, 0, 0}, {1, 0, 0}});
  CHECK(line.length() == Approx(1.0).epsilon(1e-12));
  CHECK(line.interpolate({1, 2, 2}, line.parameterAt(0.125)) == Approx(1.5).epsilon(1e-10));

  std::vector<Vector3> circle;
  for (int k = 0; k <= 64; ++k) {
    const double a = std::numbers::pi * k / 64;
    circle.emplace_back(std::cos(a), std::sin(a), 0);
  }
  const Spline half(circle);
  CHECK(half.length() == Approx(std::numbers::pi).epsilon(1e-4));
  for (double s : {0.1, 1.0, 2.0, 3.0})
    CHECK(half.lengthTo(half.parameterAt(s)) == Approx(s).epsilon(1e-10));
}

TEST_CASE("the nearest point of a curve leaves at a right angle and is nearer than any other") {
  const Spline s({{0, 0, 0}, {1, 0.5, 0}, {1.2, 2, 1}, {3, 2, 0}});
  for (const Vector3& x :
       {Vector3(0.5, 1, 0), Vector3(2, 2, 2), Vector3(-1, -1, 0), Vector3(4, 2, 1)}) {
    const double u = s.nearest(x);
    for (double other = 0.0; other <= 3.0; other += 0.01) {
      CHECK((s.at(u) - x).norm() <= (s.at(other) - x).norm() + 1e-12);
    }
    if (u > 0.0 && u < 3.0) CHECK(std::abs(s.tangent(u).dot(x - s.at(u))) < 1e-6);
  }
}

TEST_CASE("halves of any part of a curve are equally long") {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> any(0.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    std::vector<Vector3> points;
    for (int k = 0; k < 5; ++k) points.emplace_back(any(random), any(random), any(random));
    const Spline spline(points);
    const double u0 = 3.9 * any(random);
    const double u1 = u0 + (trial % 2 == 0 ? 0.02 : 1.0) * (4.0 - u0) * any(random);
    const double length = spline.lengthTo(u1) - spline.lengthTo(u0);
    REQUIRE(spline.lengthBetween(u0, u1) == Approx(length).margin(1e-10));
    const double u = spline.halfway(u0, u1);
    REQUIRE(u > u0);
    REQUIRE(u < u1);
    REQUIRE(spline.lengthBetween(u0, u) ==
            Approx(spline.lengthBetween(u, u1)).margin(1e-10 * spline.length()));
  }
  const Spline line({{0, 0, 0}, {1, 0, 0}});
  CHECK(line.lengthBetween(0.7, 0.2) == 0.0);
}
