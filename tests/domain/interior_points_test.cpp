#include <ecorche/domain/interior_points.h>
#include <support/shapes.h>

#include <catch2/catch.hpp>

using namespace ecorche;
using namespace ecorche::domain;
using mesh::Vector3;

namespace {

SizingField constantSizing(const mesh::Box& box, double length) { return {box, {}, length, 0.0}; }

}  // namespace

TEST_CASE("points fill the walls with a lattice and stay inside them") {
  const auto ball = tagged(test::sphere({0, 0, 0}, 1.0, 4), {BoundaryTag::Kind::Skin, 0});
  const double edge = 0.15;
  const auto points = interiorPoints(ball, constantSizing(mesh::boundingBox(ball.V), edge), 1.0);
  for (Eigen::Index i = 0; i < points.rows(); ++i) CHECK(points.row(i).norm() < 1.0);
  // A vertex of the body-centred lattice owns six tets
  const double lattice = 4.18879 / (6.0 * latticeTetVolume(edge));
  CHECK(static_cast<double>(points.rows()) > 0.6 * lattice);
  CHECK(static_cast<double>(points.rows()) < 1.05 * lattice);
}

TEST_CASE("where walls leak, points end at the walls' box instead of filling all of space") {
  auto open = tagged(test::box({0, 0, 0}, {1, 1, 1}), {BoundaryTag::Kind::Skin, 0});
  open.F.conservativeResize(open.F.rows() - 2, 3);
  open.tag.resize(open.tag.size() - 2);
  const auto points = interiorPoints(open, constantSizing(mesh::boundingBox(open.V), 0.1), 1.0);
  REQUIRE(points.rows() > 100);
  CHECK(points.minCoeff() >= 0.0);
  CHECK(points.maxCoeff() <= 1.0);
}
