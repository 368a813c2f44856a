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

std::set<std::int32_t> tagsIn(const TaggedSurface& surface) {
  return {surface.tag.begin(), surface.tag.end()};
}

constexpr CarveOptions kOptions{.wrapTolerance = 0.01};

}  // namespace

TEST_CASE("a box minus two overlapping boxes has the volume that it should") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  input.holes = {test::bone(test::box({1, 1, 1}, {2, 2, 2}), "a", 0),
                 test::bone(test::box({1.5, 1.25, 1.25}, {3, 1.75, 1.75}), "b", 1)};
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
  input.holes = {test::bone(test::box({1, 1, 1}, {3, 3, 3}), "outer", 0),
                 test::bone(test::sphere({2, 2, 2}, 0.5, 2), "inner", 1)};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(64 - 8));
}

TEST_CASE("bones that share a face or an edge are united, none is wrapped") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  input.holes = {test::bone(test::box({1, 1, 1}, {2, 2, 2}), "a", 0),
                 test::bone(test::box({2, 1, 1}, {3, 2, 2}), "b", 1)};
  RunContext run;
  const auto faces = carve(input, kOptions, run);
  REQUIRE(faces);
  CHECK(faces->wrapCount == 0);
  CHECK(mesh::signedVolume(faces->surface.V, faces->surface.F) == Approx(64 - 2));

  input.holes[1] = test::bone(test::box({2, 2, 1}, {3, 3, 2}), "b", 1);
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
  input.holes = {test::bone(std::move(folded), "folded", 0),
                 test::bone(test::box({1.3, 1.5, 1.2}, {1.7, 3, 1.8}), "across", 1),
                 test::bone(test::box({2.001, 1.1, 1.1}, {3, 1.9, 1.9}), "near", 2)};
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
  Hole open = test::bone(test::sphere({2, 2, 2}, 1.0, 3), "cracked", 0);
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
  input.holes = {test::bone(test::box({1, 1, 3}, {2, 2, 4.5}), "claw", 0)};
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
  input.holes = {test::bone(test::sphere({0.1, 0, 0}, 0.4, 3), "bone", 0)};
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
  input.holes = {test::bone(test::box({0.5, 1, 1}, {1, 2, 2}), "left", 0),
                 test::bone(test::box({3, 1, 1}, {3.5, 2, 2}), "right", 1),
                 test::bone(test::box({8, 1, 1}, {9, 2, 2}), "far", 2)};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(carved->leftOut == std::vector<std::size_t>{0, 2});
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(32 - 0.5));
  REQUIRE(test::hasFinding(carved->findings, "outside-skin"));

  input.holes = {test::bone(test::box({8, 1, 1}, {9, 2, 2}), "far", 0)};
  const auto outside = carve(input, kOptions, run);
  REQUIRE_FALSE(outside);
  CHECK(outside.error().code == ErrorCode::BonesOutsideSkin);

  // An obstacle out there is no bone
  input.holes.push_back(test::bone(test::box({11, 1, 1}, {12, 2, 2}), "stone", 0));
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

TEST_CASE("a bone of several pieces is judged piece by piece") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  const auto inside = test::box({1, 1, 1}, {2, 2, 2});
  const auto across = test::box({3, 1, 1}, {4.5, 2, 2});
  const auto outside = test::box({8, 1, 1}, {9, 2, 2});
  const auto pieces = [](const std::vector<mesh::SurfaceMesh>& list) {
    return test::bone(mesh::joined(list, "hyoid"), "hyoid", 0);
  };
  const auto told = [](const Carved& carved, const char* kind) {
    const auto found = std::ranges::find(carved.findings, kind, &Finding::kind);
    return found == carved.findings.end() ? Finding{} : *found;
  };
  RunContext run;
  for (const bool outsideFirst : {true, false}) {
    INFO("outside first: " << outsideFirst);
    input.holes = {
        pieces(outsideFirst ? std::vector{outside, inside} : std::vector{inside, outside})};
    const auto two = carve(input, kOptions, run);
    REQUIRE(two);
    CHECK(mesh::signedVolume(two->surface.V, two->surface.F) == Approx(64 - 1));
    CHECK(two->leftOut.empty());
    CHECK(told(*two, "outside-skin").message.find("1 of 2 pieces of \"hyoid\"") !=
          std::string::npos);
    CHECK(told(*two, "outside-skin").point->isApprox(Vector3(8.5, 1.5, 1.5)));
    CHECK_FALSE(test::hasFinding(two->findings, "pokes-out"));

    input.holes = {
        pieces(outsideFirst ? std::vector{outside, across} : std::vector{across, outside})};
    const auto crossing = carve(input, kOptions, run);
    REQUIRE(crossing);
    CHECK(mesh::signedVolume(crossing->surface.V, crossing->surface.F) == Approx(64 - 1));
    CHECK(test::hasFinding(crossing->findings, "outside-skin"));
    CHECK(told(*crossing, "pokes-out").size == Approx(0.5));
  }
  input.holes = {pieces({outside, test::box({8, 3, 1}, {9, 4, 2})})};
  const auto none = carve(input, kOptions, run);
  REQUIRE_FALSE(none);
  CHECK(none.error().code == ErrorCode::BonesOutsideSkin);

  // The piece that is beyond a cut plane goes without a word, the other stays
  input.cutPlanes = {{"middle", {2.5, 0, 0}, {-1, 0, 0}}};
  input.holes = {pieces({test::box({3, 1, 1}, {3.5, 2, 2}), inside})};
  const auto cut = carve(input, kOptions, run);
  REQUIRE(cut);
  CHECK(mesh::signedVolume(cut->surface.V, cut->surface.F) == Approx(40 - 1));
  CHECK(cut->findings.empty());
  CHECK(cut->leftOut.empty());
}

TEST_CASE(
    "a bone with one piece in another bone is united with that, whichever piece comes first") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  const auto alone = test::box({3, 3, 3}, {3.5, 3.5, 3.5});
  const auto within = test::box({1.25, 1.25, 1.25}, {1.75, 1.75, 1.75});
  RunContext run;
  for (const bool aloneFirst : {true, false}) {
    input.holes = {
        test::bone(test::box({1, 1, 1}, {2, 2, 2}), "outer", 0),
        test::bone(mesh::joined(
                       aloneFirst ? std::vector{alone, within} : std::vector{within, alone}, "two"),
                   "two", 1)};
    const auto carved = carve(input, kOptions, run);
    REQUIRE(carved);
    CHECK(test::hasFinding(carved->findings, "united"));
    CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(64 - 1 - 0.125));
  }
}

TEST_CASE("a bone that encloses one of two skins is not outside") {
  CarveInput input;
  input.skin =
      mesh::joined({test::box({0, 0, 0}, {1, 1, 1}), test::box({4, 0, 0}, {5, 1, 1})}, "skin");
  input.holes = {test::bone(test::box({-1, -1, -1}, {2, 2, 2}), "cap", 0)};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(1));
  CHECK(carved->leftOut.empty());
}

TEST_CASE("what pokes out beyond a cut plane is not told") {
  CarveInput input;
  input.skin = test::box({0, 0, 0}, {4, 4, 4});
  input.holes = {test::bone(test::box({1, 1, 1}, {4.5, 2, 2}), "claw", 0)};
  input.cutPlanes = {{"middle", {2, 0, 0}, {-1, 0, 0}}};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(32 - 1));
  CHECK(carved->findings.empty());

  // Half of what pokes out is kept
  input.cutPlanes = {{"low", {0, 1.5, 0}, {0, 1, 0}}};
  const auto half = carve(input, kOptions, run);
  REQUIRE(half);
  REQUIRE(half->findings.size() == 1);
  CHECK(half->findings[0].kind == "pokes-out");
  CHECK(half->findings[0].size == Approx(0.25).epsilon(0.01));
}

TEST_CASE("what pokes out is told where it touches itself, too") {
  // A gable whose ridge lies in the top of the bone: left and right of it the bone looks out, and
  // the two wedges touch in the ridge
  CarveInput input;
  mesh::SurfaceMesh gable = test::box({0, 0, 0}, {4, 4, 2});
  gable.V.conservativeResize(10, 3);
  gable.V.bottomRows(2) << 2, 0, 4, 2, 4, 4;
  gable.F.conservativeResize(16, 3);
  // The box's top is its third and fourth face; the roof stands on its four edges
  gable.F.row(2) << 4, 8, 6;
  gable.F.row(3) << 8, 9, 6;
  gable.F.bottomRows(4) << 5, 7, 8, 7, 9, 8, 4, 5, 8, 6, 9, 7;
  input.skin = gable;
  REQUIRE(mesh::isClosed(gable.F));
  REQUIRE(mesh::isOriented(gable.F));
  REQUIRE(mesh::signedVolume(gable.V, gable.F) == Approx(32 + 16));
  input.holes = {test::bone(test::box({1, 1, 2.5}, {3, 3, 4}), "crest", 0)};
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  const auto told = std::ranges::find(carved->findings, "pokes-out", &Finding::kind);
  REQUIRE(told != carved->findings.end());
  CHECK(told->size == Approx(2.0).epsilon(0.1));
}

TEST_CASE("the hollows of thousands of bones are found") {
  // Bones on a grid in a box of skin, each hollow: the wall of the bone faces into it, that of the
  // hollow out of it
  constexpr int kSide = 20;
  const auto skin = test::box({-1, -1, -1}, {3 * kSide, 3 * kSide, 3 * kSide});
  const auto outer = test::box({0, 0, 0}, {1, 1, 1});
  const auto inner = test::box({0.25, 0.25, 0.25}, {0.75, 0.75, 0.75});
  constexpr int kCount = kSide * kSide * kSide;
  TaggedSurface surface{
      mesh::Positions(8 * (1 + 2 * kCount), 3), mesh::Triangles(12 * (1 + 2 * kCount), 3), {}};
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

TEST_CASE("many bones that overlap are united; a cancel is heard") {
  CarveInput input;
  input.skin = test::box({-1, -1, -1}, {41, 2, 2});
  for (int i = 0; i < 40; ++i) {
    const double y = 0.1 * (i % 2);
    input.holes.push_back(
        test::bone(test::box({1.0 * i, y, 0}, {i + 1.2, y + 0.8, 1}), "v" + std::to_string(i), i));
  }
  RunContext run;
  const auto carved = carve(input, kOptions, run);
  REQUIRE(carved);
  CHECK(carved->wrapCount == 0);
  // 39 overlaps of 0.2 × 0.7 × 1
  CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) ==
        Approx(42.0 * 9 - (40 * 1.2 * 0.8 - 39 * 0.2 * 0.7)));
  run.cancel();
  const auto stopped = carve(input, kOptions, run);
  REQUIRE_FALSE(stopped);
  CHECK(stopped.error().code == ErrorCode::Cancelled);
}
