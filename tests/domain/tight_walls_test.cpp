#include <ecorche/domain/carve.h>
#include <ecorche/domain/face_octree.h>
#include <ecorche/domain/null_edges.h>
#include <ecorche/domain/resample.h>
#include <ecorche/domain/tight_places.h>
#include <ecorche/domain/wall_resampling.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_topology.h>
#include <support/shapes.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>

#include "soundness.h"

using namespace ecorche;
using namespace ecorche::domain;
using mesh::Vector3;

namespace {

/// Waves on a ball, and a coat of the same shape around it: tissue between two walls that are
/// `gap` apart everywhere.
TaggedSurface wavyFilm(double gap) {
  const auto waves = [](const Vector3& p) {
    return 0.02 * std::sin(9 * p.x()) * std::sin(8 * p.y()) * std::sin(7 * p.z());
  };
  auto inner = test::sphere({0, 0, 0}, 1.0, 5);
  auto outer = inner;
  for (Eigen::Index v = 0; v < inner.V.rows(); ++v) {
    const Vector3 p = inner.V.row(v).transpose();
    inner.V.row(v) *= 1.0 + waves(p);
    outer.V.row(v) *= 1.0 + waves(p) + gap;
  }
  inner.F.col(1).swap(inner.F.col(2));
  const auto a = tagged(outer, {BoundaryTag::Kind::Skin, 0});
  const auto b = tagged(inner, {BoundaryTag::Kind::Bone, 0});
  TaggedSurface film;
  film.V.resize(a.V.rows() + b.V.rows(), 3);
  film.V << a.V, b.V;
  film.F.resize(a.F.rows() + b.F.rows(), 3);
  film.F << a.F, b.F.array() + static_cast<std::int32_t>(a.V.rows());
  film.tag = a.tag;
  film.tag.insert(film.tag.end(), b.tag.begin(), b.tag.end());
  return film;
}

}  // namespace

TEST_CASE("an octree of boxes finds what a look at every box finds, while boxes come and go") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-1.2, 1.2);  // some lie outside of its space
  std::uniform_real_distribution<double> size(-12.0, 0.5);
  const auto someBox = [&] {
    const Vector3 at(place(random), place(random), place(random));
    const double s = std::exp2(size(random));
    return mesh::Box{at, at + s * Vector3(1.0, 0.5, 0.1 + std::abs(place(random)))};
  };
  FaceOctree tree({Vector3::Constant(-1), Vector3::Constant(1)});
  std::map<std::int32_t, mesh::Box> boxes;
  for (int step = 0; step < 4000; ++step) {
    const auto number = static_cast<std::int32_t>(random() % 700);
    tree.remove(number);
    if (boxes.erase(number) == 0) {
      boxes[number] = someBox();
      tree.add(number, boxes[number]);
    }
    if (step % 10 != 0) continue;
    const mesh::Box asked = someBox();
    std::vector<std::int32_t> found;
    tree.visit(asked, [&](std::int32_t n) {
      found.push_back(n);
      return false;
    });
    std::ranges::sort(found);
    std::vector<std::int32_t> all;
    for (const auto& [n, box] : boxes) {
      if ((box.lo.array() <= asked.hi.array()).all() && (box.hi.array() >= asked.lo.array()).all())
        all.push_back(n);
    }
    CHECK(found == all);
    int looks = 0;
    CHECK(tree.visit(asked, [&](std::int32_t) { return ++looks == 1; }) == !all.empty());
    CHECK(looks == (all.empty() ? 0 : 1));
  }
}

TEST_CASE("walls nearer than the tolerance are resampled without crossing where that is watched") {
  const double tolerance = 0.01;
  const auto film = wavyFilm(0.3 * tolerance);
  REQUIRE(mesh::selfIntersections(film.V, film.F).empty());
  ResampleOptions how{.edgeLength = [](const Vector3&) { return 0.15; },
                      .tolerance = [&](const Vector3&) { return tolerance; },
                      .loss = [&](const Vector3&) { return 1.5 * tolerance; },
                      .spacing = tolerance,
                      .watched = {}};
  RunContext run;
  const auto blind = resample(film, {}, how, run);
  REQUIRE(blind);
  CHECK_FALSE(mesh::selfIntersections(blind->V, blind->F).empty());
  how.watched = [](const Vector3&) { return true; };
  const auto watched = resample(film, {}, how, run);
  REQUIRE(watched);
  CHECK(mesh::selfIntersections(watched->V, watched->F).empty());
  CHECK(mesh::isManifold(watched->F));
  CHECK(watched->F.rows() < film.F.rows() / 4);
}

TEST_CASE("films far thinner than the tolerance cost no second round and no dense walls") {
  const double tolerance = 0.01;
  for (const double share : {0.01, 0.1, 0.5}) {
    const auto film = wavyFilm(share * tolerance);
    const SizingField sizing(mesh::boundingBox(film.V), {}, 0.15, 0.3);
    RunContext run;
    const auto out = resampleWalls(film, {}, sizing, 1.0, tolerance, run);
    REQUIRE(out);
    CHECK(out->crossings == 0);
    CHECK(out->rounds == 1);
    CHECK(out->walls.F.rows() < film.F.rows() / 3);
  }
}

TEST_CASE("places in gaps: all of a film, nothing of a ball") {
  const auto film = wavyFilm(0.005);
  CHECK(std::ssize(placesInGaps(film, 0.01)) == film.F.rows());
  CHECK(placesInGaps(film, 0.002).empty());
  CHECK(placesInGaps(tagged(test::sphere({0, 0, 0}, 1.0, 3), {}), 0.01).empty());
}

TEST_CASE("a bone that ends a hair before the cut plane, on it or behind it leaves no film") {
  for (const double hair : {-1e-9, -1e-12, 0.0, 1e-12, 1e-9, 1e-6}) {
    CarveInput input;
    input.skin = test::box({-2, -2, -2}, {2, 2, 2});
    input.holes = {test::bone(test::box({-1, hair, -1}, {1, 1, 1}), "a", 0)};
    input.cutPlanes = {{"symmetry", Vector3::Zero(), Vector3::UnitY()}};
    RunContext run;
    const auto carved = carve(input, {.wrapTolerance = 0.01}, run);
    REQUIRE(carved);
    // The bone opens the plane: no wall of the domain stands before it
    CHECK(mesh::signedVolume(carved->surface.V, carved->surface.F) == Approx(32 - 4));
    const auto plane = facesOf(carved->surface, packed({BoundaryTag::Kind::CutPlane, 0}));
    CHECK(mesh::surfaceArea(plane.V, plane.F) == Approx(16 - 4));
    CHECK(mesh::selfIntersections(carved->surface.V, carved->surface.F).empty());
    CHECK(plane.V.col(1).cwiseAbs().maxCoeff() == 0.0);
  }
}

TEST_CASE("edges of no length go, and what they held apart stays closed") {
  auto ball = test::sphere({0, 0, 0}, 1.0, 2);
  // An edge shrunk to a point
  const Vector3 middle = 0.5 * (ball.V.row(ball.F(7, 0)) + ball.V.row(ball.F(7, 1))).transpose();
  ball.V.row(ball.F(7, 0)) = ball.V.row(ball.F(7, 1)) = middle.transpose();
  const auto before = tagged(ball, {BoundaryTag::Kind::Skin, 0});
  const auto after = withoutNullEdges(before);
  CHECK(after.F.rows() == before.F.rows() - 2);
  CHECK(mesh::isClosed(after.F));
  CHECK(mesh::isManifold(after.F));
  CHECK(mesh::signedVolume(after.V, after.F) == Approx(mesh::signedVolume(before.V, before.F)));
  CHECK(withoutNullEdges(after).F == after.F);
}

TEST_CASE("ridges that cross exactly leave a domain that does not cross itself") {
  // Two roofs, their ridges in one plane and at right angles, meet in the middle of both
  const auto roof = [](int along, double up) {
    auto m = test::box({-1, -1, -0.5}, {1, 1, 0.5});
    for (Eigen::Index v = 0; v < m.V.rows(); ++v) {
      if (m.V(v, 2) * up > 0) m.V(v, 1 - along) = 0.0;  // two and two corners become a ridge
    }
    m.V.col(2).array() -= 0.5 * up;
    return m;
  };
  // Ridges of no width are two vertices on one place: part them a little
  auto below = roof(0, 1.0);
  auto above = roof(1, -1.0);
  for (Eigen::Index v = 0; v < 8; ++v) {
    if (below.V(v, 2) > -0.25) below.V(v, 1) = (v & 2) != 0 ? 1e-3 : -1e-3;
    if (above.V(v, 2) < 0.25) above.V(v, 0) = (v & 1) != 0 ? 1e-3 : -1e-3;
  }
  CarveInput input;
  input.skin = test::box({-3, -3, -3}, {3, 3, 3});
  for (const double shift : {0.0, 1e-13, 1e-9, 1e-3}) {
    auto pressed = above;
    pressed.V.col(2).array() -= shift;
    input.holes = {test::bone(below, "below", 0), test::bone(pressed, "above", 1)};
    RunContext run;
    const auto carved = carve(input, {.wrapTolerance = 0.02}, run);
    REQUIRE(carved);
    CHECK(mesh::isManifold(carved->surface.F));
    CHECK(mesh::selfIntersections(carved->surface.V, carved->surface.F).empty());
  }
}
