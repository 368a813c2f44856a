#include <ecorche/authoring/symmetry.h>
#include <ecorche/mesh/read_mesh.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "authoring/shapes.h"
#include "support/paths.h"

using namespace ecorche;
using authoring::findSymmetryPlane;
using mesh::Vector3;

namespace {

/// A body with one plane of symmetry, y = 0: lopsided in x and z.
Vector3 pear(const Vector3& p) {
  return {1.5 * p.x() + 0.4 * p.x() * p.x() * p.z() + 0.3 * p.z() * p.z(),
          (0.5 + 0.2 * p.x()) * p.y(), 0.8 * p.z() + 0.2 * p.x() * p.x() * p.x()};
}

}  // namespace

TEST_CASE("a body's one plane of symmetry is found wherever the body stands") {
  RunContext run;
  for (int turn = 0; turn < 6; ++turn) {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(0.9 * turn, Vector3(1, 2 - turn, 0.5).normalized()).toRotationMatrix();
    const Vector3 shift = turn * Vector3(0.3, -1, 0.2);
    const auto skin =
        test::ball(4, [&](const Vector3& p) -> Vector3 { return R * pear(p) + shift; });
    const auto plane = findSymmetryPlane(skin, {}, run);
    REQUIRE(plane);
    REQUIRE(plane->has_value());
    CHECK(std::abs((*plane)->normal.dot(R.col(1))) > 1.0 - 1e-6);
    CHECK(std::abs(((*plane)->point - shift).dot(R.col(1))) < 1e-3);
    CHECK((*plane)->error < 1e-3);
    CHECK((*plane)->normal.maxCoeff() == (*plane)->normal.cwiseAbs().maxCoeff());
  }
}

TEST_CASE("a body that no plane mirrors has none") {
  RunContext run;
  const auto skin = test::ball(4, [](const Vector3& p) -> Vector3 {
    const Vector3 q = pear(p);
    return {q.x(), q.y() + 0.4 * q.x() * q.z() + 0.2 * q.z() * q.z() * q.x(),
            q.z() + 0.3 * q.y() * q.x()};
  });
  const auto plane = findSymmetryPlane(skin, {}, run);
  REQUIRE(plane);
  CHECK_FALSE(plane->has_value());
  CHECK(findSymmetryPlane({}, {}, run).error().code == ErrorCode::MeshWithoutFaces);
}

TEST_CASE("the search for symmetry can be stopped") {
  RunContext run;
  run.cancel();
  CHECK(findSymmetryPlane(test::ball(2, pear), {}, run).error().code == ErrorCode::Cancelled);
}

TEST_CASE("the dog is symmetric about Y = 0 within a millimetre, turned or not") {
  if (!test::haveData("dog/SKINbody.stl")) return;
  RunContext run;
  auto skin = mesh::readMesh(test::dataFolder() / "dog" / "SKINbody.stl", {}, run).value();
  const auto plane = findSymmetryPlane(skin, {}, run).value();
  REQUIRE(plane);
  CHECK(plane->normal == Vector3::UnitY());
  CHECK(plane->point == Vector3::Zero());
  CHECK(plane->snapped);

  // Away from the frame's own planes it must be found by itself
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(0.4, Vector3(1, 0.3, -0.6).normalized()).toRotationMatrix();
  skin.V = (skin.V * R.transpose()).eval();
  const auto turned = findSymmetryPlane(skin, {}, run).value();
  REQUIRE(turned);
  CHECK_FALSE(turned->snapped);
  const mesh::Box box = mesh::boundingBox(skin);
  for (int corner = 0; corner < 8; ++corner) {
    // On the plane that was found, as far out as the dog reaches
    Vector3 p;
    for (int k = 0; k < 3; ++k) p[k] = (corner >> k & 1) != 0 ? box.hi[k] : box.lo[k];
    p -= (p - turned->point).dot(turned->normal) * turned->normal;
    CHECK(std::abs(p.dot(R.col(1))) < 1e-3);
  }
}
