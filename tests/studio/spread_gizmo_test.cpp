#include <ecorche/model/project_file.h>
#include <ecorche/studio/spread_gizmo.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "studio/hand.h"

using namespace ecorche;
using namespace ecorche::studio;
using mesh::Vector3;
using test::waitFor;
using Part = SpreadPart;

TEST_CASE("what handles of the spread are pulled to is what they become") {
  test::application();
  Session session({.tets = 30'000});
  session.start(
      model::loadProject(std::filesystem::path(ECORCHE_SOURCE_DIR) / "examples/arm/arm.ecorche")
          .value(),
      {}, true);
  OrbitCamera camera;
  camera.resize(800, 600);
  session.select({"deltoid", -1, -1, {}});
  CHECK_FALSE(SpreadGizmo::of(session, camera));  // no domain yet
  REQUIRE(waitFor([&] { return session.domain() != nullptr; }));
  camera.frame(mesh::boundingBox(session.domain()->domain.mesh.V));

  int pulled = 0;
  for (const double azimuth : {0.0, 35.0, 80.0, 130.0, 200.0, 310.0}) {
    INFO("azimuth " << azimuth);
    camera.lookFrom(azimuth, 15.0);
    for (const model::Anisotropy now : {model::Anisotropy{1.0, 1.0, 0.0}, {4.0, 0.25, 0.6}}) {
      REQUIRE(session.draft({model::SetAnisotropy{"deltoid", now}}));
      const auto gizmo = SpreadGizmo::of(session, camera);
      REQUIRE(gizmo);
      const auto middle = camera.pixelOf(0.5 * (gizmo->axes()[0][0] + gizmo->axes()[0][1])).value();
      for (const Part part : {Part::Lambda2, Part::Lambda3}) {
        const auto handle = camera.pixelOf(gizmo->handles()[part == Part::Lambda2 ? 0 : 1]).value();
        const Eigen::Vector2d way = handle - middle;
        if (way.norm() < 12.0) continue;  // it points at the eye
        ++pulled;
        const auto lambda = [&](const model::Anisotropy& a) {
          return part == Part::Lambda2 ? a.lambda2 : a.lambda3;
        };
        // Where it is it stays; twice as far out is four times the spread
        CHECK(lambda(gizmo->dragged(part, handle, handle)) == Approx(lambda(now)).epsilon(0.1));
        CHECK(lambda(gizmo->dragged(part, handle, middle + 2.0 * way)) ==
              Approx(4.0 * lambda(gizmo->dragged(part, handle, handle))).epsilon(0.02));
        CHECK(lambda(gizmo->dragged(part, handle, middle - way)) < 0.06);
        // The other numbers stay as they are
        const auto out = gizmo->dragged(part, handle, middle + 1.5 * way);
        CHECK(out.rotation == now.rotation);
        CHECK((part == Part::Lambda2 ? out.lambda3 == now.lambda3 : out.lambda2 == now.lambda2));
      }
      const auto a = camera.pixelOf(gizmo->ring()[5]).value();
      CHECK(gizmo->dragged(Part::Ring, a, a).rotation == Approx(now.rotation).margin(1e-9));
      CHECK(gizmo->under(a).has_value());
      CHECK_FALSE(gizmo->under({2.0, 2.0}));
    }
  }
  CHECK(pulled > 12);

  // A turn of the ring by a quarter turns the axes by a quarter, where the ring is not seen from
  // its edge
  REQUIRE(session.draft({model::SetAnisotropy{"deltoid", {1.0, 1.0, 0.0}}}));
  int turned = 0;
  for (const double elevation : {-70.0, -30.0, 10.0, 50.0, 80.0}) {
    for (const double azimuth : {0.0, 60.0, 120.0, 180.0, 240.0, 300.0}) {
      camera.lookFrom(azimuth, elevation);
      const auto gizmo = SpreadGizmo::of(session, camera).value();
      const auto middle = camera.pixelOf(0.5 * (gizmo.axes()[0][0] + gizmo.axes()[0][1])).value();
      const Eigen::Vector2d from = camera.pixelOf(gizmo.ring()[0]).value();
      const Eigen::Vector2d to = camera.pixelOf(gizmo.ring()[18]).value();
      const Eigen::Vector2d a = from - middle;
      const Eigen::Vector2d b = to - middle;
      if (std::abs(a.x() * b.y() - a.y() * b.x()) < 800.0) continue;
      ++turned;
      CHECK(gizmo.dragged(Part::Ring, from, to).rotation ==
            Approx(0.5 * std::numbers::pi).margin(0.02));
    }
  }
  CHECK(turned >= 5);
  session.dropDraft();

  REQUIRE(session.perform(model::SetProtected{"deltoid", true}, "protect"));
  CHECK_FALSE(SpreadGizmo::of(session, camera));
}
