// Left and right muscles are made alike.

#include <ecorche/authoring/first_curves.h>
#include <ecorche/authoring/names.h>

#include <catch2/catch.hpp>

#include <algorithm>

#include "authoring/shapes.h"

using namespace ecorche;
using namespace ecorche::authoring;
using mesh::Vector3;

namespace {

const Mirror kMirror{Vector3::Zero(), Vector3::UnitY()};

AttachmentSite patchSite(const char* bone, const Vector3& at) {
  return {.muscle = "m", .bone = bone, .at = at, .patchFile = "patch.stl"};
}

}  // namespace

TEST_CASE("twins are known by their names") {
  const auto twins = twinsIn({{"a_L", {}}, {"b_R", {}}, {"A_R", {}}, {"c", {}}});
  CHECK(twins[0] == std::size_t{2});
  CHECK(twins[2] == std::size_t{0});
  CHECK_FALSE(twins[1]);
  CHECK_FALSE(twins[3]);
}

TEST_CASE("what one twin lacks is taken from the other, mirrored, without its patch") {
  const std::vector<MuscleSites> table = {
      {"a_L", {patchSite("Rib_L_1", {0, 0.2, 0})}},
      {"a_R", {patchSite("Rib_R_1", {0, -0.201, 0}), patchSite("Jaw", {0.5, -0.1, 0})}}};
  Findings findings;
  const auto both = withTwinSites(table, kMirror, 1.0, findings);
  REQUIRE(both[0].sites.size() == 2);
  CHECK(both[0].sites[1].bone == "Jaw");
  CHECK(both[0].sites[1].at == Vector3(0.5, 0.1, 0));
  CHECK(both[0].sites[1].patchFile.empty());
  CHECK(both[1].sites.size() == 2);
  REQUIRE(findings.size() == 1);
  CHECK(findings[0].object == "a_L");
}

TEST_CASE("the second side is the lower twin, or what lies below the plane") {
  const std::vector<MuscleSites> table = {
      {"a_L", {patchSite("", {0, 0.01, 0}), patchSite("", {1, -0.002, 0})}},
      {"a_R", {patchSite("", {0, -0.01, 0}), patchSite("", {1, 0.002, 0})}},
      {"b", {patchSite("", {0, -0.3, 0}), patchSite("", {0, 0.3, 0})}},
      {"c", {patchSite("", {0, -0.3, 0})}}};
  CHECK(onSecondSide(table, kMirror, 2.0) == std::vector<bool>{false, true, false, true});
}

TEST_CASE("a muscle on both sides is folded onto the first one") {
  const MuscleSites both{"m",
                         {patchSite("Rib_L_1", {0, 0.2, 0}), patchSite("Rib_R_1", {0, -0.2, 0}),
                          patchSite("sternum", {0.1, 0, 0}), patchSite("jaw", {0.5, -0.1, 0})}};
  const FoldedSites fold = folded(both, kMirror, 1.0);
  REQUIRE(fold.sites.size() == 3);
  CHECK(fold.sites[2].bone == "jaw");
  CHECK(fold.sites[2].at == Vector3(0.5, 0.1, 0));
  REQUIRE(fold.beyond);
  CHECK(fold.beyond->bone == "Rib_R_1");
}

TEST_CASE("of a whole body the right muscles are the left ones' images on their own bones") {
  const mesh::SurfaceQuery skin(test::sphere(Vector3::Zero(), 1.0, 3));
  const std::vector<BoneSurface> bones = {
      boneSurface("spine", test::sphere(Vector3::Zero(), 0.25, 3)),
      boneSurface("femur_L", test::sphere({0.5, 0.5, 0}, 0.1, 3)),
      boneSurface("femur_R", test::sphere({0.5, -0.5, 0}, 0.1, 3)),
      boneSurface("tibia_L", test::sphere({-0.5, 0.4, 0.1}, 0.1, 3)),
      boneSurface("tibia_R", test::sphere({-0.5, -0.4, 0.1}, 0.1, 3))};
  Surroundings around{skin, bones, 2.0 * std::sqrt(3.0), Vector3::Zero(), kMirror, true};
  // The chord of a_L and a_R runs near the spine, that of b through it; c goes from side to side
  std::vector<MuscleSites> table;
  for (const double side : {1.0, -1.0}) {
    const std::string s = side > 0 ? "_L" : "_R";
    table.push_back({"a" + s,
                     {patchSite(("femur" + s).c_str(), {0.45, side * 0.41, 0}),
                      patchSite(("tibia" + s).c_str(), {-0.45, side * 0.32, 0.1})}});
    table.push_back({"b" + s,
                     {patchSite(("femur" + s).c_str(), {0.41, side * 0.45, 0}),
                      patchSite("spine", {-0.24, side * 0.05, 0})}});
  }
  table.push_back(
      {"c", {patchSite("femur_L", {0.5, 0.41, 0.05}), patchSite("femur_R", {0.5, -0.41, 0.05})}});
  RunContext run;
  const auto made = firstMuscles(table, around, run).value();
  REQUIRE(made.muscles.size() == 5);

  for (const model::Tissue& muscle : made.muscles) {
    const auto name = mirroredName(muscle.name).value_or(muscle.name);
    const auto twin = std::ranges::find(made.muscles, name, &model::Tissue::name);
    REQUIRE(twin != made.muscles.end());
    INFO(muscle.name);
    CHECK(twin->attachments.size() == muscle.attachments.size());
    REQUIRE(twin->curves.size() == muscle.curves.size());
    const model::Curve &own = muscle.curves[0], &other = twin->curves[0];
    REQUIRE(own.points.size() == other.points.size());
    const bool itself = &*twin == &muscle;
    for (std::size_t p = 0; p < own.points.size(); ++p) {
      const std::size_t q = itself ? own.points.size() - 1 - p : p;
      CHECK((kMirror.image(own.points[p].at) - other.points[q].at).norm() < 1e-4);
    }
    CHECK(mirroredName(own.start.name).value_or(own.start.name) ==
          (itself ? other.end : other.start).name);
    const Placement placed = placementOf(model::splineOf(own), around);
    CHECK(placed.outside == 0.0);
    CHECK(placed.inBone == 0.0);
  }
}
