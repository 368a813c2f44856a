#include <ecorche/render/far_faces.h>
#include <ecorche/render/offscreen.h>
#include <ecorche/render/renderer.h>
#include <ecorche/render/views.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <map>

#include "render/scenes.h"

using namespace ecorche;
using mesh::Vector3;

namespace {

// Greatest distance of a coarser face's corner, and of the middle of its face, from the ball.
double farthest(const render::FarFaces& faces, const mesh::SurfaceMesh& mesh,
                const render::ShadingMesh& shading) {
  double most = 0.0;
  for (std::size_t i = 0; i < faces.corners.size(); i += 3) {
    Vector3 middle = Vector3::Zero();
    for (std::size_t k = 0; k < 3; ++k)
      middle += mesh.V.row(shading.vertex[faces.corners[i + k]]).transpose() / 3.0;
    most = std::max(most, std::abs(middle.norm() - 1.0));
  }
  return most;
}

// Edges that are not used once in either direction.
int openEdges(const render::FarFaces& faces, const render::ShadingMesh& shading) {
  std::map<std::pair<std::int32_t, std::int32_t>, int> count;
  for (std::size_t i = 0; i < faces.corners.size(); i += 3)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t a = shading.vertex[faces.corners[i + k]];
      const std::int32_t b = shading.vertex[faces.corners[i + (k + 1) % 3]];
      count[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  return static_cast<int>(
      std::ranges::count_if(count, [](const auto& entry) { return entry.second != 0; }));
}

}  // namespace

TEST_CASE("a ball's coarser faces close it, get fewer, and stay within a cell of it") {
  const auto ball = test::ball(Vector3::Zero(), 1.0, 96);
  const auto shading = render::shadingMesh(*ball, {});
  const auto levels = render::farFaces(*ball, shading);
  REQUIRE(levels.size() >= 4);
  auto before = static_cast<std::size_t>(shading.F.rows());
  double cell = 0.0;
  for (const render::FarFaces& level : levels) {
    INFO("cell " << level.cell);
    CHECK(level.cell > cell);
    cell = level.cell;
    CHECK(level.corners.size() % 3 == 0);
    CHECK(3 * (level.corners.size() / 3) <= 2 * before);
    before = level.corners.size() / 3;
    CHECK(openEdges(level, shading) == 0);
    CHECK(farthest(level, *ball, shading) < level.cell);
  }
}

TEST_CASE("few faces, and none, have no coarser ones") {
  const auto wall = test::wall(0.0, 1.0);
  CHECK(render::farFaces(*wall, render::shadingMesh(*wall, {})).empty());
  const mesh::SurfaceMesh none;
  CHECK(render::farFaces(none, render::shadingMesh(none, {})).empty());
}

TEST_CASE("in motion a far ball is drawn of fewer faces and looks as it does of all") {
  auto context = render::OffscreenContext::create();
  REQUIRE(context);
  render::Scene scene;
  scene.surfaces.push_back(
      test::item(test::ball(Vector3::Zero(), 1.0, 160), {0.8f, 0.4f, 0.3f, 1.0f}));
  // A vanishing shift of colour per face keeps every face where it is: nothing coarser is made
  render::Scene whole = scene;
  whole.surfaces[0].faceColours = std::make_shared<const std::vector<render::Rgba>>(
      static_cast<std::size_t>(scene.surfaces[0].mesh->F.rows()), scene.surfaces[0].colour);
  auto options = test::plainOptions(48, 48);
  options.motion = true;
  const render::Camera camera{.eye = {0.0, -9.0, 2.0}, .fovDeg = 24.0};
  std::array<render::Image, 2> pictures;
  for (std::size_t i = 0; i < 2; ++i) {
    auto renderer = render::Renderer::create();
    REQUIRE(renderer);
    REQUIRE(renderer->begin(i == 0 ? scene : whole, camera, options));
    renderer->pass();
    pictures[i] = renderer->read();
  }
  int far = 0;
  double sum = 0.0;
  for (std::size_t p = 0; p < pictures[0].pixels.size(); ++p) {
    int most = 0;
    for (std::size_t c = 0; c < 3; ++c)
      most =
          std::max(most, std::abs(int(pictures[0].pixels[p][c]) - int(pictures[1].pixels[p][c])));
    far += most > 40 ? 1 : 0;
    sum += most;
  }
  INFO("mean difference " << sum / 2304.0);
  CHECK(far <= 23);  // one pixel in a hundred, at the rim
  CHECK(sum / 2304.0 < 3.0);
}

TEST_CASE("a box is beyond the picture only if none of it can be seen") {
  const render::Camera camera{.eye = {0.0, -5.0, 0.0}, .fovDeg = 30.0};
  const mesh::Box scene{Vector3::Constant(-2.0), Vector3::Constant(2.0)};
  const Eigen::Matrix4f toClip =
      render::viewProjection(camera, 200, 100, scene, Vector3::Zero()).cast<float>();
  int beyond = 0;
  for (int x = -8; x <= 8; ++x)
    for (int z = -8; z <= 8; ++z) {
      const Vector3 lo(0.5 * x - 0.3, -0.2, 0.5 * z - 0.3);
      const Vector3 hi = lo + Vector3::Constant(0.6);
      const bool away = render::isBeyondPicture(toClip, lo.cast<float>(), hi.cast<float>());
      beyond += away ? 1 : 0;
      if (!away) continue;
      for (int k = 0; k < 8; ++k) {
        const auto seen = render::project(
            camera, 200, 100,
            {(k & 1) ? hi.x() : lo.x(), (k & 2) ? hi.y() : lo.y(), (k & 4) ? hi.z() : lo.z()});
        REQUIRE(seen);
        const auto& p = seen->pixel;
        CHECK_FALSE((p.x() > 0.0 && p.x() < 200.0 && p.y() > 0.0 && p.y() < 100.0));
      }
    }
  CHECK(beyond > 100);
}
