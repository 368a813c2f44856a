#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/surface_query.h>

#include <Eigen/Geometry>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <thread>

#include "support/paths.h"
#include "support/shapes.h"

using namespace ecorche;
using namespace ecorche::mesh;

namespace {

Vector3 randomPoint(std::mt19937& random, double extent) {
  std::uniform_real_distribution<double> x(-extent, extent);
  return {x(random), x(random), x(random)};
}

SurfaceMesh turnedOver(SurfaceMesh m) {
  m.F.col(1).swap(m.F.col(2));
  return m;
}

}  // namespace

TEST_CASE("distance and side of a box agree with their closed forms") {
  const Vector3 half(1, 2, 3);
  const SurfaceQuery box(test::box(-half, half));
  std::mt19937 random(11);
  for (int trial = 0; trial < 5000; ++trial) {
    const Vector3 p = randomPoint(random, 5);
    const Vector3 out = p.cwiseAbs() - half;
    const double expected = out.cwiseMax(0.0).norm() + std::min(out.maxCoeff(), 0.0);
    REQUIRE(box.signedDistance(p) == Approx(expected).margin(1e-12));
    const auto near = box.closest(p);
    REQUIRE(near.distance == Approx(std::abs(expected)).margin(1e-12));
    REQUIRE((near.point - p).norm() == near.distance);
  }
}

TEST_CASE("inside is decided where rays meet edges and corners too") {
  const SurfaceQuery box(test::box({-1, -1, -1}, {1, 1, 1}));
  for (int x = -3; x <= 3; ++x) {
    for (int y = -3; y <= 3; ++y) {
      for (int z = -3; z <= 3; ++z) {
        const Vector3 p = Vector3(x, y, z) / 2;
        const double reach = p.cwiseAbs().maxCoeff();
        const auto winding = box.windingNumber(p);
        INFO(p.transpose());
        if (reach == 1) {
          CHECK_FALSE(winding);  // on a face, an edge or a corner
          CHECK(box.inside(p));
        } else {
          CHECK(winding == (reach < 1 ? 1 : 0));
        }
      }
    }
  }
}

TEST_CASE("the winding number tells shells within shells apart") {
  const auto winding = [](const std::vector<SurfaceMesh>& shells, const Vector3& p) {
    return SurfaceQuery(joined(shells, "shells")).windingNumber(p).value();
  };
  const SurfaceMesh outer = test::sphere({0, 0, 0}, 2, 2);
  const SurfaceMesh inner = test::sphere({0, 0, 0}, 1, 2);
  const Vector3 centre(0.01, 0.02, 0.03);
  CHECK(winding({outer}, centre) == 1);
  CHECK(winding({turnedOver(outer)}, centre) == -1);
  CHECK(winding({outer, inner}, centre) == 2);
  CHECK(winding({outer, turnedOver(inner)}, centre) == 0);
  CHECK(winding({outer, turnedOver(inner)}, {1.5, 0, 0}) == 1);
  CHECK(winding({outer, test::sphere({3, 0, 0}, 2, 2)}, {1.5, 0.01, 0}) == 2);
}

TEST_CASE("rays hit a sphere where geometry says, in order, and slip through nowhere") {
  const SurfaceMesh sphere = test::sphere({0, 0, 0}, 1, 4);
  const SurfaceQuery query(sphere);
  std::mt19937 random(12);
  for (int trial = 0; trial < 2000; ++trial) {
    // Every other ray aims at a vertex exactly: the hardest place
    const Vector3 target = trial % 2 == 0
                               ? Vector3(sphere.V.row(random() % sphere.V.rows()).transpose())
                               : Vector3(randomPoint(random, 0.5));
    const Vector3 origin = 3 * randomPoint(random, 1).normalized();
    const Vector3 direction = target - origin;
    const auto hits = query.allHits(origin, direction);
    if (hits.empty()) {
      REQUIRE(trial % 2 == 0);  // grazing a vertex of the silhouette
      continue;
    }
    REQUIRE(std::ranges::is_sorted(hits, {}, &SurfaceQuery::Hit::t));
    const auto first = query.firstHit(origin, direction);
    REQUIRE(first);
    REQUIRE(first->t == hits.front().t);
    REQUIRE(first->face == hits.front().face);
    for (const auto& hit : hits) {
      REQUIRE(hit.point.norm() == Approx(1).epsilon(0.01));
      REQUIRE((origin + hit.t * direction - hit.point).norm() < 1e-12);
      const auto row = sphere.F.row(hit.face);
      const Vector3 a = sphere.V.row(row[0]).transpose();
      const Vector3 n =
          (sphere.V.row(row[1]).transpose() - a).cross(sphere.V.row(row[2]).transpose() - a);
      REQUIRE(hit.entering == (n.dot(direction) < 0));
    }
    if (trial % 2 == 1) REQUIRE(hits.size() == 2);
    REQUIRE_FALSE(query.firstHit(origin, direction, 0.99 * hits.front().t));
  }
  CHECK_FALSE(query.firstHit({3, 0, 0}, {0, 1, 0}));
  CHECK(query.firstHit({0, 0, 0}, {0, 0, 1e-3})->t == Approx(1000).epsilon(0.01));
}

TEST_CASE("triangles without area are no trouble") {
  SurfaceMesh m = test::box({0, 0, 0}, {1, 1, 1});
  m.F.conservativeResize(14, 3);
  m.F.row(12) << 0, 0, 1;
  m.F.row(13) << 2, 2, 2;
  const SurfaceQuery query(m);
  CHECK(query.distance({2, 0.5, 0.5}) == Approx(1));
  CHECK(query.inside({0.5, 0.5, 0.5}));
  const SurfaceQuery none(m.V, m.F.bottomRows(2));
  CHECK(none.empty());
  CHECK_FALSE(none.firstHit({0, 0, 0}, {1, 0, 0}));
  CHECK_FALSE(none.inside({0, 0, 0}));
}

TEST_CASE("many threads may ask at once") {
  const SurfaceQuery query(test::sphere({0, 0, 0}, 1, 5));
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      std::mt19937 random(static_cast<unsigned>(t));
      for (int trial = 0; trial < 2000; ++trial) {
        const Vector3 p = randomPoint(random, 1.2);
        if (std::abs(p.norm() - 1) < 0.002) continue;
        const double d = query.signedDistance(p);
        if (std::abs(d - (p.norm() - 1)) > 0.002) ++wrong;
      }
    });
  }
  for (auto& thread : threads) thread.join();
  CHECK(wrong == 0);
}

TEST_CASE("deviation of two spheres is the difference of their radii, both ways") {
  RunContext run;
  const auto d =
      surfaceDeviation(test::sphere({0, 0, 0}, 1.0, 5), test::sphere({0, 0, 0}, 1.1, 5), 0.02, run);
  REQUIRE(d);
  for (const auto& way : {d->aToB, d->bToA}) {
    CHECK(way.max == Approx(0.1).epsilon(0.02));
    CHECK(way.mean == Approx(0.1).epsilon(0.01));
  }
  const auto same =
      surfaceDeviation(test::torus(2, 1, 20, 10), test::torus(2, 1, 20, 10), 0.1, run);
  REQUIRE(same);
  CHECK(same->max() < 1e-14);
}

TEST_CASE("deviation finds what sticks out on one side only, and says where") {
  RunContext run;
  const SurfaceMesh plain = test::box({0, 0, 0}, {1, 1, 1});
  const SurfaceMesh spiked = joined({plain, test::box({0.4, 0.4, 1}, {0.6, 0.6, 1.5})}, "spiked");
  const auto d = surfaceDeviation(plain, spiked, 0.05, run);
  REQUIRE(d);
  CHECK(d->aToB.max < 1e-12);
  CHECK(d->bToA.max == Approx(0.5));
  CHECK(d->bToA.place.z() == Approx(1.5));

  // A dent in the middle of one big face shows only because faces are sampled inside
  SurfaceMesh open;
  open.V = plain.V;
  open.F = plain.F.topRows(2);
  const auto lid = surfaceDeviation(plain, open, 0.05, run);
  REQUIRE(lid);
  CHECK(lid->aToB.max == Approx(1.0));
  CHECK(lid->aToB.mean > 0.3);

  run.cancel();
  CHECK(surfaceDeviation(plain, spiked, 0.05, run).error().code == ErrorCode::Cancelled);
  RunContext fresh;
  CHECK(surfaceDeviation(plain, SurfaceMesh{}, 0.05, fresh).error().code ==
        ErrorCode::MeshWithoutFaces);
}

TEST_CASE("points of the dog's bones: inside agrees with the side of the closest face") {
  if (!test::haveData("dog")) return;
  RunContext run;
  const auto bone = readMesh(test::dataFolder() / "dog/bones/BONEFemoris_L.stl", {}, run);
  REQUIRE(bone);
  const SurfaceQuery query(*bone);
  const Directions normals = vertexNormals(bone->V, bone->F);
  const double step = 1e-4 * boundingBox(*bone).diagonal();
  int agree = 0;
  int asked = 0;
  for (Eigen::Index v = 0; v < bone->V.rows(); v += 3) {
    const Vector3 p = bone->V.row(v).transpose();
    const Vector3 n = normals.row(v).transpose();
    agree += query.inside(p - step * n) ? 1 : 0;
    agree += query.inside(p + step * n) ? 0 : 1;
    asked += 2;
  }
  CHECK(agree > 0.98 * asked);
}
