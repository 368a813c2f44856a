#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/tips.h>

#include <catch2/catch.hpp>

#include "support/shapes.h"

using namespace ecorche;
using namespace ecorche::mesh;

TEST_CASE(
    "tips that touch are drawn apart by a twentieth of their shortest edge, nothing else moves") {
  // Two tetrahedra on one point
  SurfaceMesh m;
  m.V.resize(8, 3);
  m.V << 0, 0, 0, 1, -1, -1, 1, 1, -1, 1, 0, 1,  //
      0, 0, 0, -2, -1, -1, -2, 1, -1, -2, 0, 1;
  m.F.resize(8, 3);
  m.F << 0, 1, 3, 0, 2, 1, 0, 3, 2, 1, 2, 3,  //
      4, 7, 5, 4, 5, 6, 4, 6, 7, 5, 7, 6;
  REQUIRE_FALSE(selfIntersections(m.V, m.F).empty());
  const Positions before = m.V;
  CHECK(drawTipsApart(m.V, m.F) == 2);
  CHECK(selfIntersections(m.V, m.F).empty());
  CHECK(m.V(0, 0) > 0.0);
  CHECK(m.V(4, 0) < 0.0);
  CHECK(m.V.row(0).norm() == Approx(0.05 * std::sqrt(2.0)));
  CHECK(m.V.middleRows(1, 3) == before.middleRows(1, 3));
  CHECK(m.V.bottomRows(3) == before.bottomRows(3));
}

TEST_CASE("a surface whose vertices all have places of their own stays as it is") {
  auto ball = test::sphere({0, 0, 0}, 1.0, 2);
  const Positions before = ball.V;
  CHECK(drawTipsApart(ball.V, ball.F) == 0);
  CHECK(ball.V == before);
}
