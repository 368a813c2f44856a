// A drawn stroke becomes a curve in the flesh: on bodies made by rules.

#include <ecorche/authoring/stroke.h>
#include <ecorche/core/parallel.h>

#include <catch2/catch.hpp>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>

#include "authoring/body.h"
#include "authoring/shapes.h"

using namespace ecorche;
using namespace ecorche::authoring;
using mesh::Vector3;

namespace {

// Lines of sight from an eye through a straight stroke in the picture
std::vector<SightRay> straightStroke(const Vector3& eye, const Vector3& from, const Vector3& to) {
  std::vector<SightRay> out;
  constexpr int kSamples = 60;
  const Vector3 a = (from - eye).normalized();
  const Vector3 b = (to - eye).normalized();
  for (int k = 0; k <= kSamples; ++k) {
    const double t = static_cast<double>(k) / kSamples;
    out.push_back({eye, ((1.0 - t) * a + t * b).normalized()});
  }
  return out;
}

// How far a point lies from the cone of lines that the stroke makes: from the nearest of them and
// of those between neighbours
double offStroke(const std::vector<SightRay>& sights, const Vector3& p) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < sights.size(); ++i) {
    constexpr int kBetween = 64;
    for (int k = 0; k <= kBetween; ++k) {
      const double t = static_cast<double>(k) / kBetween;
      const Vector3 d =
          ((1.0 - t) * sights[i - 1].direction + t * sights[i].direction).normalized();
      const Vector3 off = p - sights[i].origin;
      least = std::min(least, (off - off.dot(d) * d).norm());
    }
  }
  return least;
}

/// A ball of skin, and two small bones left and right in it with nothing between.
struct Gap {
  mesh::SurfaceQuery skin{test::sphere(Vector3::Zero(), 1.0, 3)};
  std::vector<BoneSurface> bones = {boneSurface("left", test::sphere({-0.5, 0, 0}, 0.05, 3)),
                                    boneSurface("right", test::sphere({0.5, 0, 0}, 0.05, 3))};
  Vector3 eye{0, -4, 0};
  Vector3 from{-0.45, 0, 0};
  Vector3 to{0.45, 0, 0};
  std::vector<SightRay> sights = straightStroke(eye, from, to);

  [[nodiscard]] StrokeRoom room() const { return {&skin, bones, {}, 2.0 * std::sqrt(3.0)}; }
};

}  // namespace

TEST_CASE("without bones, skin and lean a stroke's depth is linear") {
  std::mt19937 random(5);
  const auto within = [&](double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
  };
  const std::vector<BoneSurface> none;
  const StrokeRoom empty{nullptr, none, {}, 1.0};
  DepthHabits upright;
  upright.lean = 0.0;
  for (int trial = 0; trial < 20; ++trial) {
    const Vector3 eye(within(-1, 1), -5, within(-1, 1));
    const Vector3 from(within(-1, 0), within(-1, 1), within(-1, 1));
    const Vector3 to(within(0.2, 1), within(-1, 1), within(-1, 1));
    const auto sights = straightStroke(eye, from, to);
    const auto linear = strokeInDepth(sights, from, to);
    const auto ours = strokeInFlesh(sights, from, to, empty, upright);
    CHECK(ours.front() == from);
    CHECK(ours.back() == to);
    for (const Vector3& p : ours) {
      double least = 1.0;
      for (std::size_t i = 1; i < linear.size(); ++i) {
        const Vector3 step = linear[i] - linear[i - 1];
        const double t = std::clamp((p - linear[i - 1]).dot(step) / step.squaredNorm(), 0.0, 1.0);
        least = std::min(least, (p - linear[i - 1] - t * step).norm());
      }
      CHECK(least < 1e-3);  // between samples of the stroke it is a cone, not a line
    }
  }
}

TEST_CASE("a muscle with room on all sides hangs towards the eye by its lean") {
  const Gap gap;
  const std::vector<BoneSurface> none;
  const StrokeRoom empty{nullptr, none, {}, 2.0 * std::sqrt(3.0)};
  DepthHabits habits;
  for (const double lean : {0.0, 0.05, 0.15}) {
    habits.lean = lean;
    const auto path = strokeInFlesh(gap.sights, gap.from, gap.to, empty, habits);
    // Linear depth is an arc about the eye
    const double linear = (gap.from - gap.eye).norm();
    CHECK(linear - (path[path.size() / 2] - gap.eye).norm() == Approx(lean * 0.9).margin(0.005));
  }
}

TEST_CASE("every point of a guess lies on the stroke, whatever is in the way") {
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    const test::Body body(seed);
    const mesh::SurfaceQuery skin(body.skinMesh);
    const StrokeRoom room{&skin, body.bones, {}, mesh::boundingBox(body.skinMesh).diagonal()};
    for (const MuscleSites& muscle : body.table) {
      const Vector3& from = muscle.sites[0].at;
      const Vector3& to = muscle.sites[1].at;
      const auto sights = straightStroke({0.3, -6, 0.2}, from, to);
      const auto path = strokeInFlesh(sights, from, to, room);
      CHECK(path.front() == from);
      CHECK(path.back() == to);
      for (std::size_t i = 1; i + 1 < path.size(); i += 5) CHECK(offStroke(sights, path[i]) < 1e-3);
    }
  }
}

TEST_CASE("a curve drawn between any two bones stays in the domain") {
  int curves = 0, few = 0;
  for (std::uint32_t seed = 1; seed <= 10; ++seed) {
    const test::Body body(seed);
    const mesh::SurfaceQuery skin(body.skinMesh);
    const StrokeRoom room{&skin, body.bones, {}, mesh::boundingBox(body.skinMesh).diagonal()};
    for (const MuscleSites& muscle : body.table) {
      // Where the stroke begins and ends over bone
      const Vector3 eye = Vector3(0.2, seed % 2 == 0 ? -6.0 : 6.0, 0.3);
      std::array<Vector3, 2> ends;
      for (std::size_t k = 0; k < 2; ++k) {
        const auto bone = std::ranges::find(body.bones, muscle.sites[k].bone, &BoneSurface::name);
        const auto hit = bone->surface->firstHit(eye, muscle.sites[k].at - eye);
        ends[k] = hit ? hit->point : muscle.sites[k].at;
      }
      const auto sights = straightStroke(eye, ends[0], ends[1]);
      const StrokeCurve drawn = strokeCurve(strokeInFlesh(sights, ends[0], ends[1], room), room);
      INFO("seed " << seed << ", " << muscle.muscle);
      CHECK_FALSE(drawn.leaving);
      CHECK(drawn.points.front() == ends[0]);
      CHECK(drawn.points.back() == ends[1]);
      // Asked in another way: no sample lies behind a wall
      const mesh::Spline curve(drawn.points);
      const double length = curve.length();
      for (int k = 2; k < 98; ++k) {
        const Vector3 p = curve.at(curve.parameterAt(length * k / 100.0));
        CHECK(skin.inside(p));
        for (const BoneSurface& bone : body.bones) CHECK_FALSE(bone.solid->inside(p));
      }
      ++curves;
      few += drawn.points.size() <= 8 ? 1 : 0;
    }
  }
  CHECK(curves == 80);
  CHECK(few > curves / 2);  // up to eight are soon edited
}

TEST_CASE("a bone in the way is passed on its shorter side, if nothing else is asked for") {
  const Gap gap;
  for (const double side : {-1.0, 1.0}) {
    std::vector<BoneSurface> bones = gap.bones;
    // Nearer to the eye than the straight way, or farther: the other side is shorter
    bones.push_back(boneSurface("middle", test::sphere({0, 0.12 * side, 0}, 0.2, 3)));
    const StrokeRoom room{&gap.skin, bones, {}, 2.0 * std::sqrt(3.0)};
    DepthHabits upright;
    upright.lean = 0.0;
    upright.skinWeight = 0.0;
    const StrokeCurve drawn =
        strokeCurve(strokeInFlesh(gap.sights, gap.from, gap.to, room, upright), room);
    CHECK_FALSE(drawn.leaving);
    const mesh::Spline curve(drawn.points);
    const Vector3 middle = curve.at(curve.nearest(Vector3(0, -0.2 * side, 0)));
    CHECK(middle.y() * side < -0.07);
    CHECK(std::abs(middle.z()) < 0.02);  // where it was drawn
  }
}

TEST_CASE("a guess is moved, turned and scaled with everything") {
  const test::Body body(3);
  const mesh::SurfaceQuery skin(body.skinMesh);
  const double diagonal = mesh::boundingBox(body.skinMesh).diagonal();
  const double scale = 40.0;
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(0.7, Vector3(1, 2, -1).normalized()).toRotationMatrix();
  const auto moved = [&](const Vector3& p) -> Vector3 {
    return scale * (turn * p) + Vector3(3, -1, 2);
  };
  const auto movedMesh = [&](const mesh::SurfaceMesh& mesh) {
    mesh::SurfaceMesh out = mesh;
    for (Eigen::Index v = 0; v < out.V.rows(); ++v)
      out.V.row(v) = moved(mesh.V.row(v).transpose()).transpose();
    return out;
  };
  std::vector<BoneSurface> bones, movedBones;
  for (int b = 0; b < 3; ++b) {
    const auto mesh = test::sphere(Vector3(-0.8 + 0.8 * b, 0.1 * b, 0.1), 0.15, 3);
    bones.push_back(boneSurface("bone" + std::to_string(b), mesh));
    movedBones.push_back(boneSurface("bone" + std::to_string(b), movedMesh(mesh)));
  }
  const mesh::SurfaceQuery movedSkin(movedMesh(body.skinMesh));
  const Vector3 from = bones[0].surface->closest({-0.8, -1, 0.1}).point;
  const Vector3 to = bones[2].surface->closest({0.8, -1, 0.1}).point;
  const Vector3 eye(0, -6, 0.4);
  const auto path =
      strokeInFlesh(straightStroke(eye, from, to), from, to, {&skin, bones, {}, diagonal});
  const auto other = strokeInFlesh(straightStroke(moved(eye), moved(from), moved(to)), moved(from),
                                   moved(to), {&movedSkin, movedBones, {}, scale * diagonal});
  REQUIRE(path.size() == other.size());
  for (std::size_t i = 0; i < path.size(); ++i)
    CHECK((moved(path[i]) - other[i]).norm() < 1e-6 * scale);
}

TEST_CASE("a guess is the same on one thread and on two") {
  const Gap gap;
  std::vector<std::vector<Vector3>> paths;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    paths.push_back(strokeInFlesh(gap.sights, gap.from, gap.to, gap.room()));
  }
  CHECK(paths[0] == paths[1]);
}

TEST_CASE("with an open skin a stroke still keeps out of bones") {
  const Gap gap;
  std::vector<BoneSurface> bones = gap.bones;
  bones.push_back(boneSurface("middle", test::sphere(Vector3::Zero(), 0.2, 3)));
  const StrokeRoom room{nullptr, bones, {}, 2.0 * std::sqrt(3.0)};
  const StrokeCurve drawn = strokeCurve(strokeInFlesh(gap.sights, gap.from, gap.to, room), room);
  CHECK_FALSE(drawn.leaving);
  for (const Vector3& p : mesh::Spline(drawn.points).sample(0.01).point) CHECK(p.norm() > 0.195);
}

TEST_CASE("a stroke that ends on a cut plane stays on the kept side") {
  const Gap gap;
  const model::CutPlane plane{"median", model::CutPlane::Kind::Symmetry, Vector3(0, -0.1, 0),
                              Vector3::UnitY()};
  // Bone pushes towards the eye, where the plane cuts everything off
  std::vector<BoneSurface> bones = gap.bones;
  bones.push_back(boneSurface("middle", test::sphere({-0.1, 0.35, 0}, 0.3, 3)));
  const Vector3 to(0.45, -0.1, 0);
  const StrokeRoom room{&gap.skin, bones, {plane}, 2.0 * std::sqrt(3.0)};
  const StrokeCurve drawn =
      strokeCurve(strokeInFlesh(straightStroke(gap.eye, gap.from, to), gap.from, to, room), room);
  CHECK_FALSE(drawn.leaving);
  CHECK(drawn.points.back() == to);
  for (const Vector3& p : mesh::Spline(drawn.points).sample(0.01).point) CHECK(p.y() > -0.1 - 1e-9);
}

TEST_CASE("where a curve leaves the domain is found: through what, and where") {
  const Gap gap;
  std::vector<BoneSurface> bones = gap.bones;
  bones.push_back(boneSurface("middle", test::sphere(Vector3::Zero(), 0.2, 3)));
  const model::CutPlane plane{"median", model::CutPlane::Kind::Symmetry, Vector3(0, -0.3, 0),
                              Vector3::UnitY()};
  const StrokeRoom room{&gap.skin, bones, {plane}, 2.0 * std::sqrt(3.0)};

  const auto through = firstLeaving(mesh::Spline({gap.from, gap.to}), room);
  REQUIRE(through);
  CHECK(through->what == Leaving::Through::Bone);
  CHECK(through->name == "middle");
  CHECK((through->at - Vector3(-0.2, 0, 0)).norm() < 5e-3);

  const auto out = firstLeaving(mesh::Spline({gap.from, Vector3(0, 0, 1.2), gap.to}), room);
  REQUIRE(out);
  CHECK(out->what == Leaving::Through::Skin);
  CHECK(out->at.norm() == Approx(1.0).margin(5e-3));

  const auto beyond = firstLeaving(mesh::Spline({gap.from, Vector3(0, -0.4, 0.3), gap.to}), room);
  REQUIRE(beyond);
  CHECK(beyond->what == Leaving::Through::Plane);
  CHECK(beyond->name == "median");

  // Ends on bone are none
  CHECK_FALSE(firstLeaving(mesh::Spline({gap.from, Vector3(0, 0, 0.35), gap.to}), room));
  // A bone thinner than the spacing of samples is one
  std::vector<BoneSurface> thin = gap.bones;
  thin.push_back(boneSurface("plate", test::ball(3, [](const Vector3& p) -> Vector3 {
                               return p.cwiseProduct(Vector3(1e-5, 0.3, 0.3));
                             })));
  const auto pierced =
      firstLeaving(mesh::Spline({gap.from, gap.to}), {&gap.skin, thin, {}, 2.0 * std::sqrt(3.0)});
  REQUIRE(pierced);
  CHECK(pierced->name == "plate");
}

TEST_CASE("a stroke out of a closed hollow bone is made, and told to go through it") {
  const Gap gap;
  // A shell: outward outside, inward inside
  mesh::SurfaceMesh outer = test::sphere({-0.5, 0, 0}, 0.3, 3);
  mesh::SurfaceMesh inner = test::sphere({-0.5, 0, 0}, 0.28, 3);
  inner.F.col(0).swap(inner.F.col(1));
  std::vector<BoneSurface> bones = gap.bones;
  bones.push_back(boneSurface("shell", mesh::joined({outer, inner}, "shell")));
  REQUIRE(bones.back().solid);
  const StrokeRoom room{&gap.skin, bones, {}, 2.0 * std::sqrt(3.0)};
  const StrokeCurve drawn = strokeCurve(strokeInFlesh(gap.sights, gap.from, gap.to, room), room);
  REQUIRE(drawn.leaving);
  CHECK(drawn.leaving->what == Leaving::Through::Bone);
  CHECK(drawn.leaving->name == "shell");
}
