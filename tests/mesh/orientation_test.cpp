#include <ecorche/mesh/orientation.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace ecorche::mesh;

TEST_CASE("orientation is exact where the volume drowns in rounding") {
  // Points of a plane that doubles hold exactly, one of them lifted by a single bit
  std::mt19937_64 random(3);
  std::uniform_int_distribution<int> whole(-1000, 1000);
  for (int k = 0; k < 500; ++k) {
    // d = a + i (b − a) + j (c − a) in integers, all then shifted by a number that leaves them
    // exact
    const auto point = [&] { return Vector3(whole(random), whole(random), whole(random)); };
    const Vector3 a = point();
    const Vector3 b = point();
    const Vector3 c = point();
    const double i = whole(random) / 100;
    const double j = whole(random) / 100;
    const Vector3 d = a + i * (b - a) + j * (c - a);
    const double scale = std::ldexp(1.0, -40);
    const Vector3 shift = Vector3::Constant(4096.0);
    const auto placed = [&](const Vector3& p) { return Vector3(scale * p + shift); };
    REQUIRE(orientation(placed(a), placed(b), placed(c), placed(d)) == 0);

    const Vector3 normal = (b - a).cross(c - a);
    if (normal.z() == 0.0) continue;
    Vector3 above = placed(d);
    above.z() = std::nextafter(above.z(), 1e9);
    const int up = normal.z() > 0.0 ? 1 : -1;
    REQUIRE(orientation(placed(a), placed(b), placed(c), above) == up);
    REQUIRE(orientation(placed(a), placed(c), placed(b), above) == -up);
    REQUIRE(orientation(above, placed(a), placed(b), placed(c)) == -up);
  }
}

TEST_CASE("orientation of a plain tet is the sign of its volume") {
  const Vector3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  CHECK(orientation(o, x, y, z) == 1);
  CHECK(orientation(o, y, x, z) == -1);
  CHECK(orientation(o, x, y, Vector3(0.3, 0.3, 0)) == 0);
  CHECK(orientation(o, o, y, z) == 0);
  CHECK(orientation(o, 1e-60 * x, 1e-60 * y, 1e-60 * z) == 1);
}
