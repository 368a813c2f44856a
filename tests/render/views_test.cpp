#include <ecorche/render/light_rig.h>
#include <ecorche/render/views.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "render/scenes.h"

using namespace ecorche;
using mesh::Vector3;
using render::parseView;

TEST_CASE("view texts are understood") {
  CHECK(parseView("left").value().azimuthDeg == 90.0);
  CHECK(parseView("top").value().elevationDeg == 90.0);
  const auto mixed = parseView("right,el=12.5,fov=0,zoom=2").value();
  CHECK(mixed.azimuthDeg == -90.0);
  CHECK(mixed.elevationDeg == 12.5);
  CHECK(mixed.fovDeg == 0.0);
  CHECK(mixed.zoom == 2.0);
  CHECK(parseView("az=30,el=20").value().azimuthDeg == 30.0);
  CHECK(parseView("ortho").value().fovDeg == 0.0);
}

TEST_CASE("view texts that are none say what is understood") {
  for (const char* text :
       {"", "sideways", "az=", "az=abc", "az=1x", "roll=3", "az=10,left", "left,", "az=nan"}) {
    INFO(text);
    const auto view = parseView(text);
    REQUIRE_FALSE(view);
    CHECK(view.error().code == ErrorCode::CommandSyntax);
    CHECK(view.error().message.find("three-quarter") != std::string::npos);
  }
  for (const char* text : {"el=91", "fov=-1", "fov=170", "zoom=0"}) {
    INFO(text);
    REQUIRE_FALSE(parseView(text));
    CHECK(parseView(text).error().code == ErrorCode::ValueOutOfRange);
  }
}

TEST_CASE("views look from the side they name") {
  const mesh::Box box{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
  const render::ModelAxes axes;  // nose along X, up Z: left is +Y
  const auto from = [&](const char* text) {
    const auto camera = render::framed(parseView(text).value(), axes, box, 1.5);
    return Vector3((camera.eye - camera.target).normalized());
  };
  CHECK(from("front").isApprox(Vector3::UnitX()));
  CHECK(from("back").isApprox(-Vector3::UnitX(), 1e-9));
  CHECK(from("left").isApprox(Vector3::UnitY(), 1e-9));
  CHECK(from("right").isApprox(-Vector3::UnitY(), 1e-9));
  CHECK(from("top").isApprox(Vector3::UnitZ(), 1e-9));
  CHECK(from("bottom").isApprox(-Vector3::UnitZ(), 1e-9));
  const Vector3 quarter = from("three-quarter");
  CHECK(quarter.minCoeff() > 0.1);

  // From the left the nose points to the left of the picture
  const auto camera = render::framed(parseView("left").value(), axes, box, 1.5);
  CHECK(render::eyeAxes(camera).right.isApprox(-Vector3::UnitX(), 1e-9));
}

TEST_CASE("everything is in the picture and touches its margin") {
  std::srand(7);
  int touching = 0;
  for (int round = 0; round < 40; ++round) {
    render::Scene scene;
    const Vector3 centre = 5.0 * Vector3::Random();
    auto m = test::ball(centre, 1.0, 8);
    m->V.col(round % 3) *= 1.0 + round;  // long and flat ones
    scene.surfaces.push_back(test::item(m, {1.0f, 1.0f, 1.0f, 1.0f}));
    render::View view;
    view.azimuthDeg = 9.0 * round;
    view.elevationDeg = -90.0 + 4.5 * round;
    view.fovDeg = round % 4 == 0 ? 0.0 : 10.0 + round;
    const int width = 300 + 20 * round;
    const int height = 500;
    const auto camera = render::framed(view, {}, scene, double(width) / height, 0.1);
    double free = 1e9;
    for (Eigen::Index v = 0; v < m->V.rows(); ++v) {
      const auto p = render::project(camera, width, height, Vector3(m->V.row(v)));
      REQUIRE(p);
      free =
          std::min({free, p->pixel.x(), width - p->pixel.x(), p->pixel.y(), height - p->pixel.y()});
    }
    INFO("round " << round << ", fov " << view.fovDeg);
    CHECK(free >= 0.1 * std::min(width, height) - 0.01);
    touching += free < 0.1 * std::min(width, height) + 0.5 ? 1 : 0;
  }
  // Only what is long and thin along the line of sight is seen from farther away than the frame
  // asks for
  CHECK(touching >= 36);
}

TEST_CASE("what lies outside the given box, or is cut away, does not push the rest away") {
  const Vector3 small(0.4, 0.4, 0.4);
  const auto wanted = test::ball({0, 0, 0}, 0.3, 8);
  const auto beside = test::ball({3, 0, 0}, 0.3, 8);
  render::Scene alone;
  alone.surfaces.push_back(test::item(wanted, {1.0f, 1.0f, 1.0f, 1.0f}));
  render::Scene both = alone;
  both.surfaces.push_back(test::item(beside, {1.0f, 1.0f, 1.0f, 1.0f}));
  const auto view = parseView("left").value();
  const auto eye = [&](const render::Scene& scene, const std::optional<mesh::Box>& within) {
    return render::framed(view, {}, scene, 1.5, 0.05, within).eye;
  };
  CHECK(eye(both, mesh::Box{-small, small}) == eye(alone, {}));
  CHECK(eye(both, {}).norm() > 2.0 * eye(alone, {}).norm());
  both.clip = render::ClipPlane{.point = {1, 0, 0}, .normal = {-1, 0, 0}};
  CHECK(eye(both, {}) == eye(alone, {}));
}

TEST_CASE("pixels of project() and of the matrix for OpenGL are the same") {
  render::Camera camera;
  camera.eye = {3.0, -2.0, 1.0};
  camera.target = {0.1, 0.2, 0.3};
  const mesh::Box box{{-1.0, -1.0, -1.0}, {1.0, 1.0, 1.0}};
  const Vector3 origin(0.5, 0.5, 0.5);
  for (const double fov : {0.0, 30.0}) {
    camera.fovDeg = fov;
    const auto m = render::viewProjection(camera, 640, 480, box, origin);
    for (const Vector3& p : {Vector3(0, 0, 0), Vector3(1, -1, 1), Vector3(-0.5, 0.3, 0.9)}) {
      const Eigen::Vector4d clip = m * Vector3(p - origin).homogeneous();
      const Vector3 ndc = clip.head<3>() / clip.w();
      const auto expected = render::project(camera, 640, 480, p);
      REQUIRE(expected);
      CHECK(320.0 + 320.0 * ndc.x() == Approx(expected->pixel.x()).margin(1e-9));
      CHECK(240.0 - 240.0 * ndc.y() == Approx(expected->pixel.y()).margin(1e-9));
      CHECK(std::abs(ndc.z()) <= 1.0);
    }
  }
}

TEST_CASE("every pass of a picture brings the same light") {
  render::Camera camera;
  render::LightRigOptions options;
  options.exposure = 0.8f;
  const auto eye = render::eyeAxes(camera);
  const Vector3 reference = (eye.up + eye.back).normalized();
  for (int pass = 0; pass < options.passes; ++pass) {
    float sum = 0.0f;
    for (const auto& light : render::lightsOfPass(camera, options, pass)) {
      CHECK(light.direction.norm() == Approx(1.0));
      const bool rim = light.key && light.direction.dot(eye.back) < 0.0;
      if (!rim)
        sum += light.irradiance.mean() *
               static_cast<float>(std::max(0.0, light.direction.dot(reference)));
    }
    CHECK(sum == Approx(0.8f).epsilon(1e-4));
  }
}
