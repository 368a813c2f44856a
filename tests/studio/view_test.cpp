#include <ecorche/authoring/stroke.h>
#include <ecorche/render/light_rig.h>
#include <ecorche/studio/orbit_camera.h>

#include <rapidcheck/catch.h>
#include <catch2/catch.hpp>

using namespace ecorche;
using mesh::Vector3;
using studio::OrbitCamera;

namespace {

double between(double lo, double hi) {
  return lo + (hi - lo) * *rc::gen::inRange(0, 100001) / 100000.0;
}
Vector3 place(double size) {
  return {between(-size, size), between(-size, size), between(-size, size)};
}
OrbitCamera anyCamera() {
  OrbitCamera out;
  out.resize(*rc::gen::inRange(64, 2000), *rc::gen::inRange(64, 1200));
  out.setParallel(*rc::gen::arbitrary<bool>());
  out.lookFrom(between(-180, 180), between(-89, 89));
  const Vector3 at = place(2.0);
  out.frame({at - Vector3::Constant(0.3), at + Vector3::Constant(0.3)});
  return out;
}
double distanceToLine(const authoring::SightRay& ray, const Vector3& p) {
  const Vector3 d = p - ray.origin;
  return (d - d.dot(ray.direction) * ray.direction).norm();
}

}  // namespace

TEST_CASE("a line of sight passes through what is seen at its pixel") {
  rc::prop("both ways", [] {
    const OrbitCamera camera = anyCamera();
    const Eigen::Vector2d pixel(between(0, camera.width()), between(0, camera.height()));
    const authoring::SightRay sight = camera.sight(pixel);
    RC_ASSERT(std::abs(sight.direction.norm() - 1.0) < 1e-12);
    const Vector3 p = sight.origin + between(0.2, 3.0) * sight.direction;
    const auto seen = camera.pixelOf(p);
    RC_ASSERT(seen.has_value());
    RC_ASSERT((*seen - pixel).norm() < 1e-6);
    // One pixel to the side is one pixel's length away
    const Vector3 beside = camera.placeLike(p, pixel + Eigen::Vector2d(1, 0));
    RC_ASSERT(std::abs((beside - p).norm() / camera.pixelAt(p) - 1.0) < 1e-9);
    RC_ASSERT((camera.placeLike(p, pixel) - p).norm() < 1e-9);
  });
}

TEST_CASE("hands move the eye as they expect") {
  rc::prop("what is framed is seen", [] {
    OrbitCamera camera = anyCamera();
    const Vector3 lo = place(1.0);
    const Vector3 hi = lo + Vector3(between(0.01, 1), between(0.01, 1), between(0.01, 1));
    camera.frame({lo, hi});
    for (int k = 0; k < 8; ++k) {
      const Vector3 corner((k & 1) != 0 ? hi.x() : lo.x(), (k & 2) != 0 ? hi.y() : lo.y(),
                           (k & 4) != 0 ? hi.z() : lo.z());
      const auto seen = camera.pixelOf(corner);
      RC_ASSERT(seen.has_value());
      RC_ASSERT(seen->x() >= 0 && seen->x() <= camera.width());
      RC_ASSERT(seen->y() >= 0 && seen->y() <= camera.height());
    }
  });
  rc::prop("the wheel keeps what is under it", [] {
    OrbitCamera camera = anyCamera();
    const Eigen::Vector2d pixel(between(0, camera.width()), between(0, camera.height()));
    const Vector3 before = camera.placeLike(camera.camera().target, pixel);
    camera.dolly(between(-5, 5), pixel);
    RC_ASSERT((camera.placeLike(camera.camera().target, pixel) - before).norm() < 1e-9);
  });
  rc::prop("panning moves the model with the hand", [] {
    OrbitCamera camera = anyCamera();
    const Vector3 p = camera.camera().target;
    const Eigen::Vector2d by(between(-50, 50), between(-50, 50));
    const Eigen::Vector2d before = camera.pixelOf(p).value();
    camera.pan(by.x(), by.y());
    RC_ASSERT((camera.pixelOf(p).value() - before - by).norm() < 1e-6);
  });
  rc::prop("turning there and back is nothing", [] {
    OrbitCamera camera = anyCamera();
    camera.lookFrom(between(-180, 180), 0.0);
    const render::Camera before = camera.camera();
    const double dx = between(-300, 300);
    const double dy = between(-100, 100);
    camera.orbit(dx, dy);
    camera.orbit(-dx, -dy);
    RC_ASSERT((camera.camera().eye - before.eye).norm() < 1e-9);
    RC_ASSERT((camera.camera().target - before.target).norm() == 0.0);
  });
}

TEST_CASE("a stroke in depth runs from bone to bone along its lines of sight") {
  rc::prop("each point on its own line, depths in order", [] {
    const OrbitCamera camera = anyCamera();
    const int count = *rc::gen::inRange(2, 40);
    std::vector<authoring::SightRay> sights;
    const Eigen::Vector2d a(between(0, camera.width()), between(0, camera.height()));
    const Eigen::Vector2d b(between(0, camera.width()), between(0, camera.height()));
    for (int k = 0; k < count; ++k) sights.push_back(camera.sight(a + (b - a) * k / (count - 1.0)));
    const double first = between(0.5, 2.0);
    const double last = between(0.5, 2.0);
    const Vector3 from = sights.front().origin + first * sights.front().direction;
    const Vector3 to = sights.back().origin + last * sights.back().direction;
    const auto path = authoring::strokeInDepth(sights, from, to);
    RC_ASSERT(path.size() == sights.size());
    RC_ASSERT(path.front() == from);
    RC_ASSERT(path.back() == to);
    double before = first;
    for (std::size_t i = 0; i < path.size(); ++i) {
      RC_ASSERT(distanceToLine(sights[i], path[i]) < 1e-9);
      const double depth = (path[i] - sights[i].origin).dot(sights[i].direction);
      RC_ASSERT((depth - before) * (last - first) >= -1e-9);
      before = depth;
    }
  });
}
