#include <ecorche/render/anatomy_scene.h>
#include <ecorche/render/shading_mesh.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "render/scenes.h"

using namespace ecorche;
using mesh::Vector3;

namespace {

mesh::SurfaceMesh cube() {
  mesh::SurfaceMesh m;
  m.V.resize(8, 3);
  for (int v = 0; v < 8; ++v) m.V.row(v) = Vector3(v & 1, (v >> 1) & 1, (v >> 2) & 1);
  m.F.resize(12, 3);
  m.F << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6,
      1, 3, 5, 3, 7, 5;
  return m;
}

}  // namespace

TEST_CASE("normals of a ball point away from its middle") {
  const auto ball = test::ball(Vector3(1.0, 2.0, 3.0), 2.0, 32);
  const auto s = render::shadingMesh(*ball, {});
  REQUIRE(s.normals.rows() == ball->V.rows());  // no creases: no vertex doubled
  for (Eigen::Index n = 0; n < s.normals.rows(); ++n) {
    const Vector3 out =
        (Vector3(ball->V.row(s.vertex[static_cast<std::size_t>(n)])) - Vector3(1.0, 2.0, 3.0)) /
        2.0;
    CHECK(s.normals.row(n).dot(out) > 0.999);
  }
}

TEST_CASE("a cube keeps its edges below the crease angle and loses them above") {
  const auto sharp = render::shadingMesh(cube(), {.creaseDeg = 60.0});
  CHECK(sharp.normals.rows() == 24);
  for (Eigen::Index n = 0; n < 24; ++n)
    CHECK(sharp.normals.row(n).cwiseAbs().maxCoeff() == Approx(1.0));
  const auto round = render::shadingMesh(cube(), {.creaseDeg = 100.0});
  CHECK(round.normals.rows() == 8);
  for (Eigen::Index n = 0; n < 8; ++n)
    CHECK(round.normals.row(n).cwiseAbs().isApprox(
        Eigen::RowVector3d::Constant(1.0 / std::sqrt(3.0)), 1e-9));
}

TEST_CASE("smoothing normals evens out noise and moves no vertex") {
  auto noisy = *test::ball(Vector3::Zero(), 1.0, 24);
  std::srand(3);
  noisy.V += 0.012 * mesh::Positions::Random(noisy.V.rows(), 3);
  const auto error = [&](int rounds) {
    const auto s = render::shadingMesh(noisy, {.creaseDeg = 180.0, .smoothing = rounds});
    double sum = 0.0;
    for (Eigen::Index n = 0; n < s.normals.rows(); ++n)
      sum += 1.0 -
             s.normals.row(n).dot(noisy.V.row(s.vertex[static_cast<std::size_t>(n)]).normalized());
    return sum / static_cast<double>(s.normals.rows());
  };
  CHECK(error(2) < 0.5 * error(0));
}

TEST_CASE("faces without area neither break smoothness nor bring NaN") {
  // A flat square with a sliver on its diagonal
  mesh::SurfaceMesh m;
  m.V.resize(5, 3);
  m.V << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0.5, 0.5, 0;
  m.F.resize(3, 3);
  m.F << 0, 1, 2, 0, 2, 4, 0, 2, 3;
  const auto s = render::shadingMesh(m, {});
  CHECK(s.normals.allFinite());
  for (Eigen::Index n = 0; n < s.normals.rows(); ++n)
    if (s.normals.row(n).norm() > 0.0) CHECK(s.normals(n, 2) == Approx(1.0));
}

TEST_CASE("materials look like what they are") {
  const auto ball = test::ball(Vector3::Zero(), 1.0, 8);
  using render::Material;
  const auto muscle = render::surfaceItem(Material::Muscle, ball);
  CHECK(muscle.colour[0] > 2.0f * muscle.colour[1]);
  CHECK(muscle.colour[3] == 1.0f);
  CHECK(muscle.capped);
  const auto skin = render::surfaceItem(Material::Skin, ball);
  CHECK(skin.colour[3] < 0.3f);
  CHECK(skin.edgeOpacity.value() > skin.colour[3]);
  const render::Rgba own{0.2f, 0.3f, 0.4f, 1.0f};
  CHECK(render::surfaceItem(Material::Bone, ball, own).colour == own);
}

TEST_CASE("curves, control points and fibres become items with all their points") {
  const mesh::Spline spline({{0, 0, 0}, {1, 0, 0}, {2, 1, 0}});
  const auto line = render::curveItem({spline}, {0, 0, 0, 1}, 0.1);
  REQUIRE(line.lines->size() == 1);
  CHECK(line.lines->front().size() >= 22);
  CHECK(line.onTop);
  CHECK(render::controlPointItem({spline, spline}, {1, 1, 1, 1}).points->size() == 6);
  const std::vector<std::vector<Vector3>> traced(10, {{0, 0, 0}, {1, 0, 0}});
  const auto fibres = render::fibreItem(traced, {0.4f, 0.1f, 0.1f, 1.0f}, {.keepEvery = 3});
  CHECK(fibres.lines->size() == 4);
  REQUIRE(fibres.lineColours->size() == 4);
  CHECK((*fibres.lineColours)[0] != (*fibres.lineColours)[1]);
}
