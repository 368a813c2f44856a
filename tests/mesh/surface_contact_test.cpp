#include <ecorche/mesh/surface_contact.h>
#include <ecorche/mesh/unit_check.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "damaged/damage.h"
#include "support/shapes.h"

using namespace ecorche::mesh;
using namespace ecorche;

namespace {

SurfaceMesh ball(const Vector3& at, double radius, const char* name = "ball") {
  return test::egg(at, {radius, radius, radius}, 4, name);
}
std::optional<SurfaceContact> between(const SurfaceMesh& a, const SurfaceMesh& b) {
  return contactOf(ContactBody(a), ContactBody(b), 0.01);
}

}  // namespace

TEST_CASE("two balls: apart, touching, overlapping, one within the other") {
  const SurfaceMesh a = ball({0, 0, 0}, 1.0);
  CHECK_FALSE(between(a, ball({3, 0, 0}, 1.0)));
  CHECK_FALSE(between(a, ball({2.05, 0, 0}, 1.0)));

  const auto touch = between(a, ball({2.005, 0, 0}, 1.0));
  REQUIRE(touch);
  CHECK(touch->kind == SurfaceContact::Kind::Touch);
  CHECK(touch->depth == Approx(0.005).margin(0.003));
  CHECK(touch->place.x() == Approx(1.0).margin(0.02));

  const double d = 1.5;
  const auto lens = between(a, ball({d, 0, 0}, 1.0));
  REQUIRE(lens);
  CHECK(lens->kind == SurfaceContact::Kind::Overlap);
  CHECK(lens->volume == Approx(std::numbers::pi * (4 + d) * (2 - d) * (2 - d) / 12).epsilon(0.05));
  CHECK(lens->depth == Approx(2 - d).epsilon(0.05));

  const auto within = between(ball({0.2, 0, 0}, 0.5), a);
  REQUIRE(within);
  CHECK(within->kind == SurfaceContact::Kind::Within);
  CHECK(within->volume == Approx(4.0 / 3.0 * std::numbers::pi / 8).epsilon(0.05));
}

TEST_CASE("what pokes out is measured, what lies inside is not") {
  const SurfaceMesh skin = ball({0, 0, 0}, 1.0);
  CHECK_FALSE(pokingOut(ContactBody(ball({0.2, 0, 0}, 0.5)), ContactBody(skin)));
  const auto half = pokingOut(ContactBody(ball({1.0, 0, 0}, 0.1)), ContactBody(skin));
  REQUIRE(half);
  CHECK(half->depth == Approx(0.1).epsilon(0.02));
  CHECK(half->place.x() == Approx(1.1).epsilon(0.01));
  CHECK(half->volume == Approx(0.5 * 4.0 / 3.0 * std::numbers::pi * 1e-3).epsilon(0.1));
}

TEST_CASE("other units are told by their factor, other places are not") {
  const SurfaceMesh skin = test::egg({0, 0, 1}, {0.25, 0.2, 0.9}, 3, "skin");
  const SurfaceMesh femur = test::egg({0.1, 0, 0.7}, {0.03, 0.03, 0.25}, 3, "femur");
  const SurfaceMesh skull = test::egg({0, 0, 1.7}, {0.08, 0.08, 0.1}, 3, "skull");
  const SurfaceMesh patella = test::egg({0.1, 0.05, 0.45}, {0.02, 0.01, 0.02}, 3, "patella");
  CHECK(unitMismatches(skin, {femur, skull, patella}).empty());
  CHECK(unitMismatches(skin, {patella}).empty());
  CHECK(unitMismatches(skin, {}).empty());

  for (const double factor : {10.0, 25.4, 100.0, 1000.0}) {
    INFO(factor);
    const auto all =
        unitMismatches(skin, {test::inUnits(femur, factor), test::inUnits(skull, factor)});
    REQUIRE(all.size() == 1);
    CHECK_FALSE(all[0].bone);
    CHECK(all[0].factor == factor);
    CHECK(all[0].certain);
    const auto one = unitMismatches(skin, {femur, test::inUnits(skull, factor), patella});
    REQUIRE(one.size() == 1);
    CHECK(one[0].bone == 1);
    CHECK(one[0].factor == factor);
    CHECK(one[0].message.find("\"skull\"") != std::string::npos);
    const auto small =
        unitMismatches(skin, {test::inUnits(femur, 1 / factor), test::inUnits(skull, 1 / factor)});
    REQUIRE(small.size() == 1);
    CHECK(small[0].factor == Approx(1 / factor));
    CHECK_FALSE(small[0].certain);
  }
  // Beside the body, the right size: a frame, no unit
  CHECK(unitMismatches(skin, {test::moved(femur, {3, 0, 0}), skull}).empty());
}
