#include <ecorche/authoring/first_curves.h>
#include <ecorche/authoring/new_project.h>
#include <ecorche/authoring/seats.h>
#include <ecorche/mesh/spline.h>

#include <catch2/catch.hpp>

#include "authoring/shapes.h"

using namespace ecorche;
using namespace ecorche::authoring;
using mesh::Vector3;
using model::Support;

namespace {

/// A ball of skin with a ball of bone in its middle, and two small bones left and right of it.
struct Scene {
  mesh::SurfaceQuery skin{test::sphere(Vector3::Zero(), 1.0, 3)};
  std::vector<BoneSurface> bones = {boneSurface("middle", test::sphere(Vector3::Zero(), 0.2, 3)),
                                    boneSurface("left", test::sphere({-0.7, 0, 0}, 0.1, 3)),
                                    boneSurface("right", test::sphere({0.7, 0, 0}, 0.1, 3))};
  Surroundings around{skin, bones, 2.0 * std::sqrt(3.0), Vector3(-1, 0, 0), std::nullopt};
};

AttachmentSite site(const char* bone, const Vector3& at) {
  return {.muscle = "m", .bone = bone, .at = at, .patchFile = {}};
}

}  // namespace

TEST_CASE("a curve's end snaps to what is nearest within reach, and else is free") {
  Scene scene;
  model::Project project;
  project.skin.file = "skin.obj";
  project.cutPlanes = {
      {"median", model::CutPlane::Kind::Symmetry, Vector3::Zero(), Vector3::UnitY()}};
  project.tissues = {{.name = "belly", .kind = model::Tissue::Kind::Muscle}};
  project.tissues[0].curves = {{"", {{{0, 0.5, 0}, 1}, {{0, 0.5, 0.5}, 1}}, {}, {}}};
  const SnapTargets targets = snapTargets(project, scene.bones);

  const auto bone = snapEnd({-0.7, 0.12, 0}, targets, 0.05);
  REQUIRE(bone);
  CHECK(bone->support == Support{Support::On::Bone, "left"});
  CHECK(std::abs((bone->at - Vector3(-0.7, 0, 0)).norm() - 0.1) < 2e-3);
  CHECK(bone->distance == Approx(0.02).margin(2e-3));

  const auto inside = snapEnd({0.7, 0.08, 0.01}, targets, 0.05);
  REQUIRE(inside);
  CHECK(inside->support.name == "right");

  const auto plane = snapEnd({0.4, 0.03, 0.4}, targets, 0.05);
  REQUIRE(plane);
  CHECK(plane->support == Support{Support::On::Plane, "median"});
  CHECK((plane->at - Vector3(0.4, 0, 0.4)).norm() < 1e-15);

  const auto curve = snapEnd({0.01, 0.52, 0.2}, targets, 0.05);
  REQUIRE(curve);
  CHECK(curve->support == Support{Support::On::Tissue, "belly"});
  CHECK((curve->at - Vector3(0, 0.5, 0.2)).norm() < 1e-6);
  CHECK_FALSE(snapEnd({0.01, 0.52, 0.2}, targets, 0.05, "belly"));
  CHECK_FALSE(snapEnd({0.3, 0.6, 0.3}, targets, 0.05));
}

TEST_CASE("a first curve is straight where nothing is in the way") {
  Scene scene;
  const auto points = bentCurve({-0.5, 0.5, 0}, {0.5, 0.5, 0}, scene.around);
  REQUIRE(points.size() == 4);
  for (std::size_t p = 0; p < 4; ++p)
    CHECK((points[p] - Vector3(-0.5 + p / 3.0, 0.5, 0)).norm() < 1e-12);
}

TEST_CASE("a first curve goes around bone and stays under the skin") {
  Scene scene;
  const std::vector<std::pair<Vector3, Vector3>> ways = {
      {{-0.6, 0.05, 0.02}, {0.6, 0.02, 0.05}},  // through the middle bone
      {{-0.6, 0.1, 0}, {0.6, 0.1, 0}},          // through its edge
      {{-0.85, 0.5, 0}, {0.4, 0.9, 0}},         // the chord leaves towards the skin
  };
  for (const auto& [from, to] : ways) {
    const auto points = bentCurve(from, to, scene.around);
    CHECK(points.front() == from);
    CHECK(points.back() == to);
    const mesh::Spline curve(points);
    CHECK(curve.length() < 1.3 * (to - from).norm());
    for (const Vector3& p : curve.sample(0.01).point) {
      CHECK(p.norm() > 0.195);
      CHECK(p.norm() < 1.0);
    }
  }
}

TEST_CASE("a muscle made of sites runs between the two bones they name, origin first") {
  Scene scene;
  RunContext run;
  const MuscleSites sites{
      "m_L",
      {site("right", {0.61, 0.02, 0}), site("left", {-0.6, 0, 0.01}), site("?", {-0.62, 0.03, 0})}};
  const auto made = firstMuscles({sites}, scene.around, run).value();
  REQUIRE(made.muscles.size() == 1);
  const model::Tissue& muscle = made.muscles[0];
  CHECK(muscle.side == model::Side::Left);
  REQUIRE(muscle.curves.size() == 1);
  const model::Curve& curve = muscle.curves[0];
  CHECK(curve.start ==
        Support{Support::On::Bone, "left"});  // the body's middle was said to be at x = -1
  CHECK(curve.end == Support{Support::On::Bone, "right"});
  CHECK(scene.bones[2].surface->distance(curve.points.back().at) < 1e-5);
  CHECK(muscle.attachments.size() == 3);
  CHECK(muscle.attachments[2].support.name == "left");  // the nearest, for want of a name
  CHECK(made.findings.empty());

  auto withRoles = sites;
  withRoles.sites[0].role = model::Attachment::Role::Origin;
  withRoles.sites[1].role = model::Attachment::Role::Insertion;
  CHECK(firstMuscles({withRoles}, scene.around, run)->muscles.at(0).curves[0].start.name ==
        "right");

  const auto none = firstMuscles({{"astray", {site("left", {-0.6, 0, 0}), site("?", {3, 0, 0})}},
                                  {"lone", {site("left", {-0.6, 0, 0})}}},
                                 scene.around, run)
                        .value();
  CHECK(none.muscles.empty());
  REQUIRE(none.findings.size() == 2);
  CHECK(none.findings[0].kind == "no-way");
  CHECK(none.findings[1].kind == "too-few-sites");
}

TEST_CASE("an end that another bone covers moves along its own to where it is free") {
  Scene scene;
  scene.bones.push_back(boneSurface("cap", test::sphere({-0.6, 0, 0}, 0.08, 3)));
  const FreeSpace space(scene.skin, scene.bones);
  const Seat seat =
      seatOf(site("left", {-0.6, 0, 0.001}), scene.bones, space, scene.around.diagonal);
  CHECK(seat.exposed);
  CHECK(seat.support.name == "left");
  CHECK(scene.bones[1].surface->distance(seat.at) < 1e-12);
  CHECK(scene.bones[3].surface->signedDistance(seat.at) > 0.0);
  CHECK((seat.at - Vector3(-0.6, 0, 0)).norm() < 0.16);
}

TEST_CASE(
    "with half a body what goes on beyond the plane ends on it; with the whole it goes through") {
  Scene scene;
  RunContext run;
  Surroundings half = scene.around;
  half.mirror = Mirror{Vector3::Zero(), Vector3::UnitX()};
  // Straight across is the middle bone
  const std::vector<MuscleSites> table = {
      {"across", {site("right", {0.62, 0.06, 0}), site("left", {-0.62, 0.06, 0})}}};
  const auto made = firstMuscles(table, half, run).value();
  REQUIRE(made.muscles.size() == 1);
  CHECK(made.muscles[0].attachments.size() == 1);
  const model::Curve& curve = made.muscles[0].curves.at(0);
  const bool startsOnPlane = curve.start.on == Support::On::Plane;
  CHECK((startsOnPlane ? curve.start : curve.end) == Support{Support::On::Plane, "median"});
  const Vector3 onPlane = (startsOnPlane ? curve.points.front() : curve.points.back()).at;
  CHECK(std::abs(onPlane.x()) < 1e-12);
  CHECK(onPlane.norm() > 0.2);

  half.keepsBothSides = true;
  const auto whole = firstMuscles(table, half, run).value();
  REQUIRE(whole.muscles.size() == 1);
  const model::Curve& through = whole.muscles[0].curves.at(0);
  CHECK(whole.muscles[0].attachments.size() == 2);
  CHECK(through.start == Support{Support::On::Bone, "right"});
  CHECK(through.end == Support{Support::On::Bone, "left"});
  CHECK(through.points.size() == 2 * curve.points.size() - 1);
}

TEST_CASE("symmetry is asked for in words") {
  const auto y = symmetryFrom("-y=2.5", model::Unit::Centimetre);
  REQUIRE(y);
  CHECK(y->flip);
  CHECK(std::get<GivenSymmetry>(y->choice).axis == 1);
  CHECK(std::get<GivenSymmetry>(y->choice).offset == 0.025);
  CHECK(std::holds_alternative<FindSymmetry>(symmetryFrom("auto", model::Unit::Metre)->choice));
  CHECK(std::holds_alternative<NoSymmetry>(symmetryFrom("none", model::Unit::Metre)->choice));
  for (const char* bad : {"", "-", "w", "y=", "y=a", "y 1", "yes"})
    CHECK_FALSE(symmetryFrom(bad, model::Unit::Metre));
}
