#include <ecorche/core/contract.h>
#include <ecorche/render/picking.h>
#include <ecorche/render/ray_caster.h>
#include <ecorche/render/views.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

namespace ecorche::render {
namespace {

using Eigen::Vector2d;
using mesh::Vector3;

constexpr double kFar = std::numeric_limits<double>::infinity();

bool isTransparent(const SurfaceItem& item) {
  if (!item.faceColours) return item.colour[3] < 1.0f;
  return std::ranges::any_of(*item.faceColours, [](const Rgba& c) { return c[3] < 1.0f; });
}

bool takenAway(const std::optional<ClipPlane>& clip, const Vector3& p) {
  return clip && clip->normal.dot(p - clip->point) < 0.0;
}

bool meets(const Ray& ray, const mesh::Box& box) {
  double from = 0.0;
  double to = kFar;
  for (int c = 0; c < 3; ++c) {
    if (ray.direction(c) == 0.0) {
      if (ray.from(c) < box.lo(c) || ray.from(c) > box.hi(c)) return false;
      continue;
    }
    const double a = (box.lo(c) - ray.from(c)) / ray.direction(c);
    const double b = (box.hi(c) - ray.from(c)) / ray.direction(c);
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to;
}

// The eye, and the pixel that is looked at.
struct Look {
  const Camera& camera;
  int width;
  int height;
  Vector2d pixel;
  Ray ray;

  [[nodiscard]] double distance(const Vector3& p) const {
    return (p - ray.from).dot(ray.direction);
  }
};

// Something thin near the pixel, before it is known whether it is hidden.
struct Thin {
  Pick pick;
  double beside = kFar;  // pixels
  bool onTop = false;

  // On top goes first, then what is nearer to the pixel by more than a pixel, then to the eye
  [[nodiscard]] bool before(const Thin& other) const {
    if (other.pick.kind == Pick::Kind::Nothing) return true;
    if (onTop != other.onTop) return onTop;
    if (std::abs(beside - other.beside) > 1.0) return beside < other.beside;
    return pick.distance < other.pick.distance;
  }
};

// What lies a hair behind a surface is drawn on it
double allowance(const Look& look, double distance) {
  const double pixel = pixelSize(look.camera, look.height);
  return 4.0 * pixel * (look.camera.fovDeg > 0.0 ? distance : 1.0);
}

Thin nearestPoint(const Scene& scene, const Look& look, double reach, double hiddenFrom) {
  Thin best;
  for (std::size_t i = 0; i < scene.points.size(); ++i) {
    const PointItem& item = scene.points[i];
    if (!item.points) continue;
    for (std::size_t n = 0; n < item.points->size(); ++n) {
      const Vector3& p = (*item.points)[n];
      const auto seen = project(look.camera, look.width, look.height, p);
      if (!seen) continue;
      Thin thin;
      thin.beside = (seen->pixel - look.pixel).norm();
      thin.onTop = item.onTop;
      if (thin.beside > reach + static_cast<double>(item.radiusPixels)) continue;
      thin.pick = {.kind = Pick::Kind::Point, .item = i, .index = n, .at = p};
      thin.pick.distance = look.distance(p);
      if (!item.onTop && thin.pick.distance > hiddenFrom + allowance(look, thin.pick.distance))
        continue;
      if (thin.before(best)) best = thin;
    }
  }
  return best;
}

Thin nearestLine(const Scene& scene, const Look& look, double reach, double hiddenFrom) {
  Thin best;
  for (std::size_t i = 0; i < scene.lines.size(); ++i) {
    const LineItem& item = scene.lines[i];
    if (!item.lines) continue;
    for (std::size_t n = 0; n < item.lines->size(); ++n) {
      const std::vector<Vector3>& line = (*item.lines)[n];
      double along = 0.0;
      for (std::size_t k = 1; k < line.size(); ++k) {
        const Vector3& a = line[k - 1];
        const Vector3& b = line[k];
        const double before = along;
        along += (b - a).norm();
        const auto pa = project(look.camera, look.width, look.height, a);
        const auto pb = project(look.camera, look.width, look.height, b);
        if (!pa || !pb) continue;
        const Vector2d d = pb->pixel - pa->pixel;
        const double s =
            d.squaredNorm() > 0.0
                ? std::clamp((look.pixel - pa->pixel).dot(d) / d.squaredNorm(), 0.0, 1.0)
                : 0.0;
        Thin thin;
        thin.beside = (pa->pixel + s * d - look.pixel).norm();
        thin.onTop = item.onTop;
        if (thin.beside > reach + 0.5 * static_cast<double>(item.widthPixels)) continue;
        // Equal steps on the screen are not equal in space where the line recedes
        const double t =
            look.camera.fovDeg > 0.0 ? s * pa->depth / (s * pa->depth + (1.0 - s) * pb->depth) : s;
        const Vector3 p = a + t * (b - a);
        if (item.clipped && takenAway(scene.clip, p)) continue;
        thin.pick = {.kind = Pick::Kind::Line, .item = i, .index = n, .at = p};
        thin.pick.along = before + t * (b - a).norm();
        thin.pick.distance = look.distance(p);
        if (!item.onTop && thin.pick.distance > hiddenFrom + allowance(look, thin.pick.distance))
          continue;
        if (thin.before(best)) best = thin;
      }
    }
  }
  return best;
}

}  // namespace

const Picker::Known& Picker::known(const SurfaceItem& item) {
  Known& k = known_[item.mesh.get()];
  if (k.query && k.mesh == item.mesh && k.revision == item.revision) return k;
  k.mesh = item.mesh;
  k.revision = item.revision;
  k.box = mesh::boundingBox(*item.mesh);
  k.query = std::make_unique<mesh::SurfaceQuery>(*item.mesh);
  return k;
}

Pick Picker::pick(const Scene& scene, const Camera& camera, int width, int height,
                  const Vector2d& pixel, const PickOptions& options) {
  EC_REQUIRE(width > 0 && height > 0);
  // Trees of surfaces that are no longer in the scene go
  std::erase_if(known_, [&](const auto& entry) {
    return std::ranges::none_of(
        scene.surfaces, [&](const SurfaceItem& item) { return item.mesh.get() == entry.first; });
  });

  const Look look{camera, width, height, pixel, rayThrough(camera, width, height, pixel)};
  Pick nearest;
  nearest.distance = kFar;
  if (options.surfaces || options.veils) {
    for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
      const SurfaceItem& item = scene.surfaces[i];
      if (!(isTransparent(item) ? options.veils : options.surfaces)) continue;
      const Known& k = known(item);
      if (k.query->empty() || !meets(look.ray, k.box)) continue;
      for (const auto& hit : k.query->allHits(look.ray.from, look.ray.direction)) {
        if (hit.t >= nearest.distance) break;
        if (item.clipped && takenAway(scene.clip, hit.point)) continue;
        nearest = {.kind = Pick::Kind::Surface,
                   .item = i,
                   .index = static_cast<std::size_t>(hit.face),
                   .at = hit.point};
        nearest.distance = hit.t;
        const mesh::SurfaceMesh& m = *item.mesh;
        const Vector3 a = m.V.row(m.F(hit.face, 0)).transpose();
        const Vector3 b = m.V.row(m.F(hit.face, 1)).transpose();
        const Vector3 c = m.V.row(m.F(hit.face, 2)).transpose();
        nearest.normal = (b - a).cross(c - a).normalized();
        if (nearest.normal.dot(look.ray.direction) > 0.0) nearest.normal = -nearest.normal;
        break;
      }
    }
  }
  if (options.tissues && scene.volume) {
    const auto hit = castRay(look.ray, *scene.volume, scene.clip);
    if (hit && hit->distance < nearest.distance) {
      nearest = {.kind = Pick::Kind::Tissue, .tissue = hit->tissue, .at = hit->at};
      nearest.normal = hit->normal;
      nearest.distance = hit->distance;
    }
  }

  if (options.points) {
    const Thin point = nearestPoint(scene, look, options.reach, nearest.distance);
    if (point.pick.kind != Pick::Kind::Nothing) return point.pick;
  }
  if (options.lines) {
    const Thin line = nearestLine(scene, look, options.reach, nearest.distance);
    if (line.pick.kind != Pick::Kind::Nothing) return line.pick;
  }
  if (nearest.kind == Pick::Kind::Nothing) nearest.distance = 0.0;
  return nearest;
}

}  // namespace ecorche::render
