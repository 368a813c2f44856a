#include <ecorche/mesh/tet_locator.h>
#include <ecorche/render/ray_caster.h>
#include <ecorche/render/views.h>
#include <ecorche/render/volume_layers.h>
#include <ecorche/tissue/segmentation.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <catch2/catch.hpp>
#include <random>

#include "render/volumes.h"
#include "support/generated_anatomy.h"
#include "support/generated_domain.h"

using namespace ecorche;
using mesh::Vector3;
using render::Ray;
using render::VolumeHit;

namespace {

Ray randomRay(const mesh::Box& box, std::mt19937_64& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const auto inside = [&] {
    return Vector3(
        box.lo + (box.hi - box.lo).cwiseProduct(Vector3(unit(random), unit(random), unit(random))));
  };
  std::normal_distribution<double> normal;
  const Vector3 away = Vector3(normal(random), normal(random), normal(random)).normalized();
  const Vector3 from = box.centre() + 2.0 * box.diagonal() * away;
  return {from, (inside() - from).normalized()};
}

// The tissue of a point, by asking each tet: no ray is walked.
TissueId tissueAt(const render::VolumeItem& item, const mesh::TetLocator& locator,
                  const Vector3& p) {
  const mesh::TetMesh& m = item.geometry->mesh();
  const std::int32_t t = locator.locate(p);
  if (t < 0) return kNoTissue;
  Eigen::Matrix4d M;
  for (int k = 0; k < 4; ++k) M.col(k) << m.V.row(m.T(t, k)).transpose(), 1.0;
  const Eigen::Vector4d b = M.inverse() * Eigen::Vector4d(p.x(), p.y(), p.z(), 1.0);
  Eigen::RowVectorXd f = Eigen::RowVectorXd::Zero(item.fields->cols());
  for (int k = 0; k < 4; ++k) f += b(k) * item.fields->row(m.T(t, k));
  return tissue::ownerOf(f, item.fatIsCandidate);
}

// A muscle that is a slab of a box: the field rises along x and passes fat at x = 0.4.
render::VolumeItem slab(int cells = 6) {
  const auto domain = test::boxDomain({.cells = {cells, cells, cells}});
  tissue::FieldMatrix f(domain.mesh.V.rows(), 2);
  f.col(0).setConstant(0.4);
  f.col(1) = domain.mesh.V.col(0);
  return test::volumeItem(domain, f, true);
}

}  // namespace

TEST_CASE("a ray meets a slab where its field passes that of fat") {
  const render::VolumeItem item = slab();
  const Ray ray{{-1.0, 0.37, 0.61}, Vector3::UnitX()};
  const auto hit = render::castRay(ray, item);
  REQUIRE(hit);
  CHECK(hit->tissue == kFirstMuscle);
  CHECK(hit->where == VolumeHit::Where::Interface);
  CHECK(hit->at.x() == Approx(0.4).margin(1e-9));
  CHECK(hit->distance == Approx(1.4).margin(1e-9));
  CHECK((hit->normal + Vector3::UnitX()).norm() < 1e-6);

  // From the other side the slab begins with the domain
  const auto back = render::castRay({{2.0, 0.37, 0.61}, -Vector3::UnitX()}, item);
  REQUIRE(back);
  CHECK(back->where == VolumeHit::Where::Boundary);
  CHECK(back->at.x() == Approx(1.0).margin(1e-9));
  CHECK((back->normal - Vector3::UnitX()).norm() < 1e-6);

  // Cut open, fat shows in the cut and muscle behind it
  const render::ClipPlane low{{0.2, 0.0, 0.0}, Vector3::UnitX()};
  const auto fat = render::castRay(ray, item, low);
  REQUIRE(fat);
  CHECK(fat->tissue == kFat);
  CHECK(fat->where == VolumeHit::Where::Cut);
  CHECK(fat->at.x() == Approx(0.2).margin(1e-9));
  CHECK((fat->normal + Vector3::UnitX()).norm() < 1e-9);
  const render::ClipPlane high{{0.7, 0.0, 0.0}, Vector3::UnitX()};
  CHECK(render::castRay(ray, item, high)->tissue == kFirstMuscle);
  CHECK_FALSE(render::castRay(ray, item, render::ClipPlane{{0.2, 0.0, 0.0}, -Vector3::UnitX()}));
}

TEST_CASE("rays along edges, through vertices and within faces of a grid meet what is there") {
  const render::VolumeItem item = slab(4);
  for (const double y : {0.0, 0.25, 0.5, 0.375, 1.0})
    for (const double z : {0.0, 0.25, 0.5, 0.625, 1.0}) {
      const auto hit = render::castRay({{-1.0, y, z}, Vector3::UnitX()}, item);
      INFO("y " << y << ", z " << z);
      // The nudge decides what happens on the hull
      if (y == 0.0 || z == 0.0 || y == 1.0 || z == 1.0) continue;
      REQUIRE(hit);
      CHECK(hit->at.x() == Approx(0.4).margin(1e-6));
    }
  const auto diagonal = render::castRay({{-1.0, -1.0, -1.0}, Vector3::Ones().normalized()}, item);
  REQUIRE(diagonal);
  CHECK(diagonal->at.x() == Approx(0.4).margin(1e-6));
}

TEST_CASE("tissues along a ray are those of the points on it, without gaps") {
  for (std::uint64_t seed = 0; seed < 63; ++seed) {
    const auto anatomy = test::generatedAnatomy(seed);
    if (!anatomy.smooth) continue;
    INFO(anatomy.name);
    const render::VolumeItem item = test::volumeItem(anatomy);
    const mesh::TetLocator locator(item.geometry->mesh());
    const double size = item.geometry->box().diagonal();
    std::mt19937_64 random(seed);
    for (int round = 0; round < 40; ++round) {
      const Ray ray = randomRay(item.geometry->box(), random);
      const auto spans = render::tissuesAlong(ray, item);
      for (std::size_t i = 1; i < spans.size(); ++i)
        REQUIRE(spans[i].enter >= spans[i - 1].leave - 1e-12);
      std::size_t at = 0;
      int wrong = 0;
      for (int k = 0; k < 400; ++k) {
        const double s = size * (0.5 + 3.0 * (k + 0.5) / 400.0);
        while (at < spans.size() && spans[at].leave < s) ++at;
        // Just beside a change both answers are right
        bool near = false;
        for (const auto& span : spans)
          near = near || std::abs(span.enter - s) < 1e-6 * size ||
                 std::abs(span.leave - s) < 1e-6 * size;
        if (near) continue;
        const TissueId along =
            at < spans.size() && spans[at].enter <= s ? spans[at].tissue : kNoTissue;
        wrong += along != tissueAt(item, locator, ray.from + s * ray.direction) ? 1 : 0;
      }
      CHECK(wrong == 0);
    }
  }
}

TEST_CASE("what is hit is the first visible piece of the ray") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto anatomy = test::generatedAnatomy(seed);
    INFO(anatomy.name);
    render::VolumeItem item = test::volumeItem(anatomy);
    std::mt19937_64 random(seed + 100);
    for (std::size_t i = 1; i < item.tissues.size(); ++i)
      item.tissues[i].visible = (random() & 3u) != 0;
    for (int round = 0; round < 50; ++round) {
      const Ray ray = randomRay(item.geometry->box(), random);
      const auto hit = render::castRay(ray, item);
      std::optional<render::TissueSpan> first;
      for (const auto& span : render::tissuesAlong(ray, item))
        if (!first && item.tissues[static_cast<std::size_t>(span.tissue.value - 1)].visible)
          first = span;
      REQUIRE(hit.has_value() == first.has_value());
      if (!hit) continue;
      CHECK(hit->tissue == first->tissue);
      CHECK(hit->distance == Approx(first->enter).margin(1e-9));
      CHECK(hit->normal.norm() == Approx(1.0).margin(1e-5));
    }
  }
}

TEST_CASE(
    "gradients averaged at vertices are exact for a linear field, and normals point outward") {
  const auto domain = test::boxDomain({.cells = {5, 5, 5}, .jitter = 0.2});
  const Vector3 slope(0.3, -1.1, 0.7);
  tissue::FieldMatrix f(domain.mesh.V.rows(), 2);
  f.col(0).setConstant(0.2);
  f.col(1) = domain.mesh.V * slope;
  const auto item = test::volumeItem(domain, f, true);
  for (std::int32_t v = 0; v < domain.mesh.V.rows(); ++v)
    CHECK((render::interfaceNormal(*item.geometry, f, v, 1, 0).cast<double>() + slope.normalized())
              .norm() < 1e-5);
}

TEST_CASE("rays through pixels are the other way round of projecting") {
  for (const double fov : {0.0, 30.0}) {
    render::Camera camera;
    camera.eye = {1.0, -3.0, 0.7};
    camera.target = {0.1, 0.2, 0.3};
    camera.fovDeg = fov;
    for (const auto& pixel : {Eigen::Vector2d(3.5, 70.5), Eigen::Vector2d(120.0, 10.25)}) {
      const Ray ray = render::rayThrough(camera, 160, 90, pixel);
      CHECK(ray.direction.norm() == Approx(1.0));
      const auto back = render::project(camera, 160, 90, ray.from + 2.5 * ray.direction);
      REQUIRE(back);
      CHECK((back->pixel - pixel).norm() < 1e-9);
    }
  }
}
