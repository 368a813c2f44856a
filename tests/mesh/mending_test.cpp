#include <ecorche/mesh/mending.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_wrap.h>
#include <ecorche/mesh/thin_out.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "damaged/damage.h"
#include "mesh/repairs.h"
#include "support/shapes.h"

using namespace ecorche;
using namespace ecorche::mesh;

namespace {

SurfaceMesh ballOf(int levels = 4) { return test::egg({0.1, 0.2, 0.3}, {1, 1, 1}, levels, "ball"); }

Result<RepairedSurface> mend(const SurfaceMesh& m, Mending how) {
  RunContext run;
  return mendSurface(m, how, run);
}
}  // namespace

TEST_CASE("the words of mending are told and read alike") {
  for (const Mending how : {Mending::None, Mending::FillHoles, Mending::OuterHull, Mending::Wrap})
    CHECK(mendingNamed(name(how)) == how);
  CHECK_FALSE(mendingNamed("glue"));
}

TEST_CASE("what is not asked for is not done") {
  SurfaceMesh open = test::without(ballOf(), [](const Vector3& p) { return p.z() > 0.8; });
  const auto same = mend(open, Mending::None);
  REQUIRE(same);
  CHECK(same->mesh.F == open.F);
  CHECK(same->findings.empty());
}

TEST_CASE("a large hole is capped over its border") {
  const double height = 0.5;
  const SurfaceMesh open =
      test::without(ballOf(), [&](const Vector3& p) { return p.z() > 0.3 + height; });
  RunContext run;
  REQUIRE_FALSE(repairSurface(open, {.mustClose = true}, run));
  const auto r = mend(open, Mending::FillHoles);
  REQUIRE(r);
  CHECK(isUncrossed(r->mesh));
  // A ball less a cap of height 1 − h
  const double cap = 1.0 - height;
  const double volume = std::numbers::pi * (4.0 / 3.0 - cap * cap * (3.0 - cap) / 3.0);
  CHECK(signedVolume(r->mesh.V, r->mesh.F) == Approx(volume).epsilon(0.03));
  const Finding* hole = findingOf(*r, "hole");
  REQUIRE(hole);
  CHECK(hole->point->z() == Approx(0.3 + height).margin(0.05));
}

TEST_CASE("an outer hull drops inner coats, hollows and walls, and moves nothing") {
  const SurfaceMesh outer = ballOf();
  const SurfaceMesh inner = test::scaled(outer, 0.8);
  const auto r =
      mend(test::together({outer, test::insideOut(inner), test::scaled(outer, 0.5)}, "shell"),
           Mending::OuterHull);
  REQUIRE(r);
  CHECK(isUncrossed(r->mesh));
  CHECK(r->mesh.F.rows() == outer.F.rows());
  CHECK(signedVolume(r->mesh.V, r->mesh.F) ==
        Approx(signedVolume(outer.V, outer.F)).epsilon(1e-12));
  CHECK(findingOf(*r, "outer-hull"));
}

TEST_CASE("a wrap is closed, lies outside, and says truly how far") {
  const SurfaceMesh torn = test::riddled(test::noisy(ballOf(), 0.01, 3), 0.03, 4);
  const auto r = mend(torn, Mending::Wrap);
  REQUIRE(r);
  CHECK(isUncrossed(r->mesh));
  const Finding* wrap = findingOf(*r, "wrap");
  REQUIRE(wrap);
  RunContext run;
  const auto apart = surfaceDeviation(torn, r->mesh, 0.02, run);
  REQUIRE(apart);
  // Nothing of the mesh sticks out, and no vertex of it is farther off than was said
  const SurfaceQuery query(r->mesh);
  for (const std::int32_t v : torn.F.reshaped())
    CHECK(query.windingNumber(torn.V.row(v).transpose()).value_or(0) == 1);
  CHECK(apart->aToB.max <= wrap->size + 0.02);
}

TEST_CASE("a wrap can be cancelled, and refuses what has no area") {
  RunContext run;
  run.cancel();
  const auto stopped = wrapSurface(ballOf(), 0.01, 0.003, run);
  REQUIRE_FALSE(stopped);
  CHECK(stopped.error().code == ErrorCode::Cancelled);
  SurfaceMesh flat = ballOf(1);
  flat.V.setZero();
  RunContext other;
  const auto nothing = wrapSurface(flat, 0.01, 0.003, other);
  REQUIRE_FALSE(nothing);
  CHECK(nothing.error().code == ErrorCode::MeshWithoutFaces);
}

TEST_CASE("a dense surface is thinned out to what can be told apart, truly so") {
  const SurfaceMesh dense = ballOf(6);  // 82 k faces
  RunContext run;
  const double allowed = 1e-3;
  const auto thinned = thinOut(dense, allowed, run);
  REQUIRE(thinned);
  REQUIRE(thinned->has_value());
  const ThinnedSurface& t = **thinned;
  CHECK(t.mesh.F.rows() < dense.F.rows() / 4);
  CHECK(t.deviation <= allowed);
  CHECK(isUncrossed(t.mesh));
  const auto apart = surfaceDeviation(t.mesh, dense, 0.01, run);
  REQUIRE(apart);
  CHECK(apart->max() <= 1.2 * t.deviation);
  // Nothing to be saved on what is coarse already
  const auto coarse = thinOut(ballOf(1), 1e-6, run);
  REQUIRE(coarse);
  CHECK_FALSE(coarse->has_value());
}

TEST_CASE("seams whose sides have different vertices are closed without moving anything") {
  const SurfaceMesh m = ballOf(3);
  const SurfaceMesh bad = test::withTJunctions(m, 9);
  RunContext run;
  const auto r = repairSurface(bad, {.mustClose = true}, run);
  REQUIRE(r);
  CHECK(checkSurface(r->mesh).isSound());
  CHECK(signedVolume(r->mesh.V, r->mesh.F) == Approx(signedVolume(m.V, m.F)).epsilon(1e-9));
  CHECK(findingOf(*r, "t-junctions"));
}

TEST_CASE("walls that divide the inside go, those that bound it stay") {
  const SurfaceMesh m = test::ringedEgg({0, 0, 0}, {1, 0.9, 2}, 15, 20, "egg");
  const SurfaceMesh walled = test::withInnerWall(m, 0.0);
  RunContext run;
  const auto r = repairSurface(walled, {.mustClose = true}, run);
  REQUIRE(r);
  CHECK(r->mesh.F.rows() == m.F.rows());
  CHECK(signedVolume(r->mesh.V, r->mesh.F) == Approx(signedVolume(m.V, m.F)).epsilon(1e-12));
  const Finding* wall = findingOf(*r, "inner-wall");
  REQUIRE(wall);
  CHECK(wall->point->z() == Approx(0.0).margin(1e-9));
}
