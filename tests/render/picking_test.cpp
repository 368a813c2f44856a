#include <ecorche/render/picking.h>
#include <ecorche/render/views.h>

#include <catch2/catch.hpp>

#include "render/scenes.h"
#include "render/volumes.h"
#include "support/generated_domain.h"

using namespace ecorche;
using mesh::Vector3;
using render::Pick;

namespace {

// A ball behind a muscle that is the right half of a box, and a curve with its points; seen along
// +Y in a picture of 4 m and 160 pixels.
render::Scene anatomyScene() {
  render::Scene scene;
  scene.surfaces.push_back(test::item(test::ball({0.0, 2.0, 0.0}, 1.5), {0.9f, 0.9f, 0.8f, 1.0f}));
  const auto domain =
      test::boxDomain({.cells = {6, 6, 6}, .lo = {-0.5, -0.5, -0.5}, .hi = {0.5, 0.5, 0.5}});
  tissue::FieldMatrix f(domain.mesh.V.rows(), 2);
  f.col(0).setConstant(0.0);
  f.col(1) = domain.mesh.V.col(0);
  scene.volume = test::volumeItem(domain, f, true);
  render::LineItem line;
  line.lines = std::make_shared<std::vector<std::vector<Vector3>>>(
      1, std::vector<Vector3>{{-1.0, 0.0, 1.0}, {0.0, 0.0, 1.0}, {1.0, 0.0, 1.0}});
  scene.lines.push_back(line);
  render::PointItem points;
  points.points = std::make_shared<std::vector<Vector3>>(
      std::vector<Vector3>{{-1.0, 0.0, 1.0}, {0.25, 0.0, 0.25}});
  scene.points.push_back(points);
  return scene;
}

Pick at(const render::Scene& scene, double x, double z, const render::PickOptions& options = {}) {
  render::Picker picker;
  const auto camera = test::straightCamera(4.0);
  const auto seen = render::project(camera, 160, 160, {x, 0.0, z});
  return picker.pick(scene, camera, 160, 160, seen->pixel, options);
}

}  // namespace

TEST_CASE("what is seen is what is picked: muscle, bone, curve, point, nothing") {
  const render::Scene scene = anatomyScene();
  const Pick muscle = at(scene, 0.3, -0.2);
  CHECK(muscle.kind == Pick::Kind::Tissue);
  CHECK(muscle.tissue == kFirstMuscle);
  CHECK(muscle.at.y() == Approx(-0.5).margin(1e-6));
  // Left of x = 0 the box is fat, which is not seen: the bone behind it is
  const Pick bone = at(scene, -0.3, -0.2);
  REQUIRE(bone.kind == Pick::Kind::Surface);
  CHECK(bone.item == 0);
  CHECK(bone.at.y() == Approx(2.0 - std::sqrt(2.25 - 0.09 - 0.04)).margin(0.01));
  CHECK(bone.normal.y() < -0.9);
  CHECK(at(scene, -1.9, -1.9).kind == Pick::Kind::Nothing);

  const Pick line = at(scene, 0.5, 1.02);
  REQUIRE(line.kind == Pick::Kind::Line);
  CHECK(line.along == Approx(1.5).margin(1e-6));
  CHECK((line.at - Vector3(0.5, 0.0, 1.0)).norm() < 1e-6);
  const Pick point = at(scene, -1.0, 0.98);
  CHECK(point.kind == Pick::Kind::Point);
  CHECK(point.index == 0);
}

TEST_CASE("a point inside a muscle is found only where it is drawn on top") {
  render::Scene scene = anatomyScene();
  CHECK(at(scene, 0.25, 0.25).kind == Pick::Kind::Tissue);
  scene.points[0].onTop = true;
  const Pick point = at(scene, 0.25, 0.25);
  CHECK(point.kind == Pick::Kind::Point);
  CHECK(point.index == 1);
}

TEST_CASE("what is hidden, cut away or transparent is not picked") {
  render::Scene scene = anatomyScene();
  scene.volume->tissues[1].visible = false;
  CHECK(at(scene, 0.3, -0.2).kind == Pick::Kind::Surface);
  scene = anatomyScene();
  scene.clip = render::ClipPlane{{0.0, 0.2, 0.0}, Vector3::UnitY()};
  const Pick cut = at(scene, 0.3, -0.2);
  CHECK(cut.kind == Pick::Kind::Tissue);
  CHECK(cut.at.y() == Approx(0.2).margin(1e-6));
  CHECK((cut.normal + Vector3::UnitY()).norm() < 1e-9);

  scene = anatomyScene();
  scene.surfaces.push_back(test::item(test::wall(-3.0, 2.0), {0.8f, 0.7f, 0.6f, 0.2f}));
  CHECK(at(scene, 0.3, -0.2).kind == Pick::Kind::Tissue);
  const Pick skin = at(scene, 0.3, -0.2, {.veils = true});
  CHECK(skin.kind == Pick::Kind::Surface);
  CHECK(skin.item == 1);
}
