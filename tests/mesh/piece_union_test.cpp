#include <ecorche/mesh/outer_hull.h>
#include <ecorche/mesh/piece_union.h>
#include <ecorche/mesh/surface_check.h>

#include <catch2/catch.hpp>
#include <random>

#include "mesh/repairs.h"
#include "support/shapes.h"

using namespace ecorche;
using namespace ecorche::mesh;

TEST_CASE("pieces that lie upon one another: their union, where an outer hull gives up") {
  // Unit cubes in a row, each leaning on the last with half of a side
  std::vector<SurfaceMesh> cubes;
  for (int i = 0; i < 9; ++i)
    cubes.push_back(test::box({1.0 * i, 0.5 * (i % 2), 0}, {1.0 * i + 1, 0.5 * (i % 2) + 1, 1}));
  const SurfaceMesh row = onePart(cubes);
  RunContext run;
  CHECK_FALSE(outerHull(row, run));
  const auto sum = pieceUnion(row, run);
  REQUIRE(sum);
  CHECK(isUncrossed(*sum));
  CHECK(checkSurface(*sum).components.size() == 1);
  CHECK(signedVolume(sum->V, sum->F) == Approx(9.0).epsilon(1e-12));
}

TEST_CASE("the union of crossing pieces is their outer hull, in whatever order they come") {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(-1.0, 1.0);
  for (int trial = 0; trial < 10; ++trial) {
    std::vector<SurfaceMesh> balls;
    for (int i = 0; i < 6; ++i)
      balls.push_back(test::sphere({place(random), place(random), place(random)}, 0.6, 2));
    RunContext run;
    const auto hull = outerHull(onePart(balls), run);
    const auto sum = pieceUnion(onePart(balls), run);
    std::ranges::reverse(balls);
    const auto reversed = pieceUnion(onePart(balls), run);
    REQUIRE(hull);
    REQUIRE(sum);
    REQUIRE(reversed);
    CHECK(signedVolume(sum->V, sum->F) == Approx(signedVolume(hull->V, hull->F)).epsilon(1e-9));
    CHECK(signedVolume(reversed->V, reversed->F) ==
          Approx(signedVolume(sum->V, sum->F)).epsilon(1e-9));
  }
}

TEST_CASE("no union for one piece, for a hollow, after a cancel") {
  RunContext run;
  CHECK_FALSE(pieceUnion(test::box({0, 0, 0}, {1, 1, 1}), run));
  auto hollow = test::box({0.2, 0.2, 0.2}, {0.8, 0.8, 0.8});
  hollow.F.col(1).swap(hollow.F.col(2));
  CHECK_FALSE(pieceUnion(onePart({test::box({0, 0, 0}, {1, 1, 1}), hollow}), run));
  run.cancel();
  CHECK_FALSE(
      pieceUnion(onePart({test::box({0, 0, 0}, {1, 1, 1}), test::box({1, 0, 0}, {2, 1, 1})}), run));
}
