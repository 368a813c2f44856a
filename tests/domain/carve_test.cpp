#include <ecorche/domain/carve.h>
#include <ecorche/domain/pockets.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_topology.h>
#include <support/shapes.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <set>

#include "soundness.h"

using namespace ecorche;
using namespace ecorche::domain;
using mesh::Vector3;

namespace {

Hole bone(mesh::SurfaceMesh mesh, std::string name, int index) {
  mesh.name = name;
  return {std::move(name), std::move(mesh), {BoundaryTag::Kind::Bone, index}, true};
}

std::set<std::int32_t> tagsIn(const TaggedSurface& surface) {
  return {surface.tag.begin(), surface.tag.end()};
}

constexpr CarveOptions kOptions{.wrapTolerance = 0.01};

}  // namespace

TEST_CASE("a box minus two overlapping boxes has the volume that it should") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  input.holes = {bone(test::box({1, 1, 1}, {2, 2, 2}), "a", 0),
                 bone(test::box({1.5, 1.25, 1.25}, {3, 1.75, 1.75}), "b", 1)};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(64 - 1 - 1.0 * 0.25));
  CHECK(mesh::isClosed(carved->surface.F));
  CHECK(mesh::isManifold(carved->surface.F));
  CHECK(carved->wrapCount == 0);
  CHECK(test::hasFinding(carved->findings, "united"));
  CHECK(tagsIn(carved->surface).size() == 3);
}

TEST_CASE("a bone within a bone adds nothing") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  input.holes = {bone(test::box({1, 1, 1}, {3, 3, 3}), "outer", 0),
                 bone(test::sphere({2, 2, 2}, 0.5, 2), "inner", 1)};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(64 - 8));
}

TEST_CASE("bones that share a face or an edge are united, none is wrapped") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  input.holes = {bone(test::box({1, 1, 1}, {2, 2, 2}), "a", 0),
                 bone(test::box({2, 1, 1}, {3, 2, 2}), "b", 1)};
  RunContext run;
  const auto faces = carve(input, kOptions, run);
  REQUIRE(faces);
  CHECK(faces->wrapCount == 0);
  CHECK(mesh::signedVolume(faces->surface.V, faces->surface.F) == Approx(64 - 2));

  input.holes[1] = bone(test::box({2, 2, 1}, {3, 3, 2}), "b", 1);
  const auto edges = carve(input, kOptions, run);
  REQUIRE(edges);
  CHECK(edges->wrapCount == 0);
  CHECK(mesh::isManifold(edges->surface.F));
  CHECK(mesh::selfIntersections(edges->surface.V, edges->surface.F).empty());
  CHECK(tagsIn(edges->surface).size() == 3);
  const auto told = std::ranges::find(edges->findings, "united", &Finding::kind);
  REQUIRE(told != edges->findings.end());
  CHECK(told->message.find("grown by 0.2 mm") != std::string::npos);
  // One of the cubes has grown by a hair, and a cube has a surface of 6
  const double volume = mesh::signedVolume(edges->surface.V, edges->surface.F);
  CHECK(volume < 64 - 2);
  CHECK(volume > 64 - 2 - 6 * 0.05 * kOptions.wrapTolerance);
}

TEST_CASE("a wrap that reaches a neighbour is united with it") {
  // A bone that cuts itself though it is called fit can only be wrapped with what it touches, and
  // the wrap lies outside by more than the gap to the third bone
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  auto folded = mesh::joined(
      {test::box({1, 1, 1}, {1.6, 2, 2}), test::box({1.4, 1.1, 1.1}, {2, 1.9, 1.9})}, "folded");
  input.holes = {bone(std::move(folded), "folded", 0),
                 bone(test::box({1.3, 1.5, 1.2}, {1.7, 3, 1.8}), "across", 1),
                 bone(test::box({2.001, 1.1, 1.1}, {3, 1.9, 1.9}), "near", 2)};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(carved->wrapCount == 1);
  CHECK(carved->wrapped == std::vector<std::size_t>{0, 1});
  CHECK(mesh::selfIntersections(carved->surface.V, carved->surface.F).empty());
  CHECK(tagsIn(carved->surface).size() == 4);
}

TEST_CASE("an open bone is wrapped") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  Hole open = bone(test::sphere({2, 2, 2}, 1.0, 3), "cracked", 0);
  open.mesh.F.conservativeResize(open.mesh.F.rows() - 1, 3);
  open.fit = false;
  input.holes = {open};
  RunContext run;
  const auto carved = carve(input, {.wrapTolerance = 0.3}, run);
  REQUIRE(carved);
  CHECK(carved->wrapCount == 1);
  CHECK(test::hasFinding(carved->findings, "wrapped"));
}

TEST_CASE("what pokes out of the skin is cut off and its volume told") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  input.holes = {bone(test::box({1, 1, 3}, {2, 2, 4.5}), "claw", 0)};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(64 - 1));
  REQUIRE(test::hasFinding(carved->findings, "pokes-out"));
  for (const Finding& f : carved->findings) {
    if (f.kind == "pokes-out") CHECK(f.size == Approx(0.5));
  }
}

TEST_CASE(
    "cut planes keep one side, and their vertices lie on them exactly where the normal is an "
    "axis") {
  CarveInput input;
  input.skin = test::sphere({0, 0, 0}, 1.0, 4);
  input.holes = {bone(test::sphere({0.1, 0, 0}, 0.4, 3), "bone", 0)};
  input.cutPlanes = {{"median", {0, 0.1, 0}, {0, 1, 0}},
                     {"slant", {0.2, 0, 0}, Vector3(-1, 0, 1).normalized()}};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(tagsIn(carved->surface).size() == 4);
  for (Eigen::Index f = 0; f < carved->surface.F.rows(); ++f) {
    const BoundaryTag tag = unpacked(carved->surface.tag[static_cast<std::size_t>(f)]);
    for (int k = 0; k < 3; ++k) {
      const Vector3 p = carved->surface.V.row(carved->surface.F(f, k)).transpose();
      for (const CutPlane& plane : input.cutPlanes)
        CHECK(plane.normal.dot(p - plane.point) > -1e-12);
      if (tag == BoundaryTag{BoundaryTag::Kind::CutPlane, 0}) CHECK(p.y() == 0.1);
    }
  }
}

TEST_CASE("a cut through the skin's own vertices works") {
  // The icosphere has vertices and whole edges on the coordinate planes
  CarveInput input;
  input.skin = test::sphere({0, 0, 0}, 1.0, 3);
  const double whole = mesh::signedVolume(input.skin.V, input.skin.F);
  for (int axis = 0; axis < 3; ++axis) {
    input.cutPlanes = {{"middle", {0, 0, 0}, Vector3::Unit(axis)}};
    RunContext run;
    const auto carved = carve(input, kOptions, run);
    REQUIRE(carved);
    CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(0.5 * whole));
  }
}

TEST_CASE("a cut does not depend on which point of the plane is given") {
  CarveInput input;
  input.skin = test::sphere({0, 0, 100}, 1.0, 3);
  const double half = 0.5 * mesh::signedVolume(input.skin.V, input.skin.F);
  for (const Vector3& point : {Vector3(0, 0, 100), Vector3(0, 0, 0), Vector3(-700, 0, 95)}) {
    input.cutPlanes = {{"middle", point, Vector3::UnitY()}};
    RunContext run;
    const auto carved = carve(input, kOptions, run);
    REQUIRE(carved);
    CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(half));
  }
  // All of it on the kept side, far from the plane
  input.cutPlanes = {{"below", {0, 0, 0}, Vector3::UnitZ()}};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(2.0 * half));
}

TEST_CASE(
    "bones beyond a cut plane are left out without a word; bones outside the skin are named") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  input.cutPlanes = {{"middle", {2, 0, 0}, {1, 0, 0}}};
  input.holes = {bone(test::box({0.5, 1, 1}, {1, 2, 2}), "left", 0),
                 bone(test::box({3, 1, 1}, {3.5, 2, 2}), "right", 1),
                 bone(test::box({8, 1, 1}, {9, 2, 2}), "far", 2)};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(carved->leftOut == std::vector<std::string>{"left", "far"});
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(32 - 0.5));
  REQUIRE(test::hasFinding(carved->findings, "outside-skin"));

  input.holes = {bone(test::box({8, 1, 1}, {9, 2, 2}), "far", 0)};
  const auto outside = carve(input, kOptions, run);
  REQUIRE_FALSE(outside);
  CHECK(outside.error().code == ErrorCode::BonesOutsideSkin);

  // An obstacle out there is no bone
  input.holes.push_back(bone(test::box({11, 1, 1}, {12, 2, 2}), "stone", 0));
  input.holes.back().tag.kind = BoundaryTag::Kind::Obstacle;
  const auto both = carve(input, kOptions, run);
  REQUIRE_FALSE(both);
  CHECK(both.error().message.find("the only bone, \"far\"") != std::string::npos);
}

TEST_CASE("nothing left of the skin is an error that names the plane") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  input.cutPlanes = {{"too far", {10, 0, 0}, {1, 0, 0}}};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE_FALSE(carved);
  CHECK(carved.error().code == ErrorCode::EmptyDomain);
  CHECK(carved.error().message.find("too far") != std::string::npos);
}

TEST_CASE("the hollows of thousands of bones are found") {
  // Bones on a grid in a box of skin, each hollow: the wall of the bone faces into it, that of the
  // hollow out of it
  constexpr int kSide = 20;
  const auto skin = test::box({-1, -1, -1}, {3 * kSide, 3 * kSide, 3 * kSide});
  const auto outer = test::box({0, 0, 0}, {1, 1, 1});
  const auto inner = test::box({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75});
  constexpr int kCount = kSide * kSide * kSide;
  TaggedSurface surface{mesh::Positions(8 * (1 + 2 * kCount), 3),
                        mesh::Triangles(12 * (1 + 2 * kCount), 3), {}};
  int next = 0;
  const auto add = [&](const mesh::SurfaceMesh& box, const Vector3& at, bool turned,
                       BoundaryTag tag) {
    surface.V.middleRows(8 * next, 8) = box.V.rowwise() + at.transpose();
    auto F = surface.F.middleRows(12 * next, 12);
    F = box.F.array() + 8 * next;
    if (turned) F.col(0).swap(F.col(1));
    surface.tag.insert(surface.tag.end(), 12, packed(tag));
    ++next;
  };
  add(skin, Vector3::Zero(), false, {BoundaryTag::Kind::Skin, 0});
  for (int i = 0; i < kCount; ++i) {
    const Vector3 at = 2.9 * Vector3(i % kSide, i / kSide % kSide, i / kSide / kSide);
    add(outer, at, true, {BoundaryTag::Kind::Bone, i});
    add(inner, at, false, {BoundaryTag::Kind::Bone, i});
  }
  const auto pockets = dropPockets(surface);
  CHECK(pockets.size() == kCount);
  CHECK(surface.F.rows() == 12 * (1 + kCount));
  CHECK(mesh::signedVolume(surface.V, surface.F) ==
        Approx(mesh::signedVolume(skin.V, skin.F) - kCount));
}
