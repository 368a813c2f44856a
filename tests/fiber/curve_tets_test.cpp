#include <ecorche/fiber/curve_tets.h>

#include <catch2/catch.hpp>

#include "fiber/fibers.h"

using namespace ecorche;
using fiber::FiberField;
using fiber::FiberOptions;
using mesh::Vector3;
using namespace ecorche::test;

TEST_CASE("a line in faces and edges of tets is measured once") {
  // The axis of a cylinder runs along edges of its grid, a shifted one through insides
  const Shape shape = makeShape(cylinder());
  std::vector<std::int32_t> upper;
  std::vector<std::int32_t> all;
  for (Eigen::Index t = 0; t < shape.anatomy.mesh.T.rows(); ++t) {
    all.push_back(static_cast<std::int32_t>(t));
    if (centroid(shape, t).z() > 0.1) upper.push_back(static_cast<std::int32_t>(t));
  }
  for (const double x : {0.0, 0.0013}) {
    const std::vector<Vector3> line{
        {x, x / 3, -0.1}, {x, x / 3, 0.03}, {x, x / 3, 0.15}, {x, x / 3, 0.3}};
    // Half of it outside, a quarter in each half
    CHECK(fiber::shareInside(shape.anatomy.mesh, all, {line}) == Approx(0.5).epsilon(1e-12));
    CHECK(fiber::shareInside(shape.anatomy.mesh, upper, {line}) == Approx(0.25).epsilon(1e-12));
    double sum = 0.0;
    for (const auto& hit : fiber::tetsOnCurve(shape.anatomy.mesh, all, line)) {
      CHECK(angleDeg(hit.tangent, Vector3::UnitZ()) < 1e-6);
      sum += hit.length;
    }
    CHECK(sum >= 0.2 * (1 - 1e-12));
  }
}
