#include <ecorche/core/contract.h>
#include <ecorche/render/light_rig.h>
#include <ecorche/render/views.h>
#include <ecorche/tissue/segmentation.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace ecorche::render {
namespace {

using mesh::Vector3;

constexpr double kDegree = std::numbers::pi / 180.0;

struct NamedView {
  std::string_view name;
  double azimuthDeg;
  double elevationDeg;
};
constexpr std::array kNamedViews{
    NamedView{"front", 0.0, 0.0},           NamedView{"back", 180.0, 0.0},
    NamedView{"left", 90.0, 0.0},           NamedView{"right", -90.0, 0.0},
    NamedView{"top", 90.0, 90.0},           NamedView{"bottom", 90.0, -90.0},
    NamedView{"three-quarter", 52.0, 14.0}, NamedView{"three-quarter-right", -52.0, 14.0}};

constexpr const char* kKnown =
    "front, back, left, right, top, bottom, three-quarter, three-quarter-right, ortho, or az=, "
    "el=, "
    "fov=, zoom= with a number";

Result<void> setNumber(View& view, std::string_view key, std::string_view text) {
  const std::string value(text);
  std::size_t used = 0;
  double x = 0.0;
  try {
    x = std::stod(value, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (used == 0 || used != value.size() || !std::isfinite(x))
    return fail(ErrorCode::CommandSyntax,
                fmt::format("view: \"{}={}\" is not a number; known: {}", key, value, kKnown));
  const auto within = [&](double lo, double hi) -> Result<void> {
    if (x >= lo && x <= hi) return {};
    return fail(ErrorCode::ValueOutOfRange,
                fmt::format("view: {}={} lies outside {} to {}", key, x, lo, hi));
  };
  if (key == "az") {
    view.azimuthDeg = x;
    return {};
  }
  if (key == "el") {
    view.elevationDeg = x;
    return within(-90.0, 90.0);
  }
  if (key == "fov") {
    view.fovDeg = x;
    return within(0.0, 120.0);
  }
  if (key == "zoom") {
    view.zoom = x;
    return within(0.01, 1000.0);
  }
  return fail(ErrorCode::CommandSyntax,
              fmt::format("view: \"{}\" is unknown; known: {}", key, kKnown));
}

// Eye axes of a view: from where, and which way is up in the picture.
void direction(const View& view, const ModelAxes& axes, Vector3& back, Vector3& up) {
  const Vector3 modelUp = axes.up.normalized();
  const Vector3 forward = (axes.forward - axes.forward.dot(modelUp) * modelUp).normalized();
  const Vector3 left = modelUp.cross(forward);
  const double az = view.azimuthDeg * kDegree;
  const double el = view.elevationDeg * kDegree;
  const Vector3 level = std::cos(az) * forward + std::sin(az) * left;
  back = std::cos(el) * level + std::sin(el) * modelUp;
  // The picture's up turns with the elevation, so that it is defined straight from above too.
  up = std::cos(el) * modelUp - std::sin(el) * level;
}

template <class Visit>
void visitPoints(const Scene& scene, const Visit& visit) {
  for (const SurfaceItem& item : scene.surfaces)
    for (Eigen::Index i = 0; i < item.mesh->F.size(); ++i)
      visit(Vector3(item.mesh->V.row(item.mesh->F.data()[i])));
  for (const LineItem& item : scene.lines)
    if (item.lines)
      for (const auto& line : *item.lines)
        for (const Vector3& p : line) visit(p);
  for (const PointItem& item : scene.points)
    if (item.points)
      for (const Vector3& p : *item.points) visit(p);
  if (!scene.volume) return;
  // Vertices of visible tissues, and beside the clip plane of those that show in the cut
  const VolumeItem& volume = *scene.volume;
  const mesh::Positions& V = volume.geometry->mesh().V;
  const double beside = 0.01 * volume.geometry->box().diagonal();
  for (Eigen::Index v = 0; v < V.rows(); ++v) {
    const TissueId owner = tissue::ownerOf(volume.fields->row(v), volume.fatIsCandidate);
    const VolumeTissue& look = volume.tissues[static_cast<std::size_t>(owner.value - 1)];
    const Vector3 p = V.row(v).transpose();
    const bool inCut =
        look.inCut && scene.clip &&
        std::abs(scene.clip->normal.normalized().dot(p - scene.clip->point)) < beside;
    if (look.visible || inCut) visit(p + look.shift);
  }
}

// Fits by tangents: in eye axes a point (x, y, z) is inside while |x| ≤ (d − z)·tx; the smallest d
// and the shift that centres follow from the extremes of x ± z·tx.
template <class Points>
Camera framedPoints(const View& view, const ModelAxes& axes, const Points& forEach, double aspect,
                    double margin) {
  EC_REQUIRE(aspect > 0.0 && margin >= 0.0 && margin <= 0.4);
  Camera camera;
  camera.fovDeg = view.fovDeg;
  Vector3 back, up;
  direction(view, axes, back, up);
  const Vector3 right = up.cross(back);

  const double half = 1.0 - 2.0 * margin;  // of the picture's height that may be used
  const double halfX = (aspect - 2.0 * margin * std::min(1.0, aspect)) / aspect;
  const double halfY = aspect < 1.0 ? 1.0 - 2.0 * margin * aspect : half;
  const double ty = view.fovDeg > 0.0 ? std::tan(0.5 * view.fovDeg * kDegree) : 0.0;
  const double tx = ty * aspect;
  const double ux = tx * halfX;
  const double uy = ty * halfY;

  constexpr double kFar = std::numeric_limits<double>::infinity();
  double maxXPlus = -kFar, maxXMinus = -kFar, maxYPlus = -kFar, maxYMinus = -kFar;
  double minZ = kFar, maxZ = -kFar;
  forEach([&](const Vector3& p) {
    const double x = p.dot(right), y = p.dot(up), z = p.dot(back);
    maxXPlus = std::max(maxXPlus, x + z * ux);
    maxXMinus = std::max(maxXMinus, -x + z * ux);
    maxYPlus = std::max(maxYPlus, y + z * uy);
    maxYMinus = std::max(maxYMinus, -y + z * uy);
    minZ = std::min(minZ, z);
    maxZ = std::max(maxZ, z);
  });
  camera.up = up;
  if (!(minZ <= maxZ)) {  // nothing to see
    camera.target = Vector3::Zero();
    camera.eye = back;
    return camera;
  }

  const double x = 0.5 * (maxXPlus - maxXMinus);
  const double y = 0.5 * (maxYPlus - maxYMinus);
  const double z = 0.5 * (minZ + maxZ);
  camera.target = x * right + y * up + z * back;
  const double spanX = maxXPlus + maxXMinus;
  const double spanY = maxYPlus + maxYMinus;
  const double size = std::max({spanX, spanY, maxZ - minZ, 1e-12});
  if (view.fovDeg <= 0.0) {
    camera.orthoHeight =
        std::max({spanY / halfY, spanX / (halfX * aspect), 1e-9 * size}) / view.zoom;
    camera.eye = camera.target + (size + (maxZ - minZ)) * back;
    return camera;
  }
  // Never inside the model, however flat it looks from here
  const double fit = std::max(spanX / (2.0 * ux), spanY / (2.0 * uy));
  const double distance = std::max(fit - z, 0.5 * (maxZ - minZ) + 0.02 * size);
  camera.eye = camera.target + distance * back;
  camera.fovDeg = 2.0 * std::atan(ty / view.zoom) / kDegree;
  return camera;
}

}  // namespace

Result<View> parseView(std::string_view text) {
  View view;
  bool first = true;
  for (bool more = true; more;) {
    const std::size_t comma = text.find(',');
    const std::string_view word = text.substr(0, comma);
    more = comma != std::string_view::npos;
    if (more) text.remove_prefix(comma + 1);
    const std::size_t equals = word.find('=');
    if (equals != std::string_view::npos) {
      if (auto ok = setNumber(view, word.substr(0, equals), word.substr(equals + 1)); !ok)
        return passOn(ok);
    } else if (word == "ortho") {
      view.fovDeg = 0.0;
    } else {
      const auto named = std::find_if(kNamedViews.begin(), kNamedViews.end(),
                                      [&](const NamedView& v) { return v.name == word; });
      if (named == kNamedViews.end() || !first)
        return fail(ErrorCode::CommandSyntax,
                    fmt::format("view: \"{}\" is unknown; known: {}", word, kKnown));
      view.azimuthDeg = named->azimuthDeg;
      view.elevationDeg = named->elevationDeg;
    }
    first = false;
  }
  return view;
}

Camera framed(const View& view, const ModelAxes& axes, const mesh::Box& box, double aspect,
              double margin) {
  const auto corners = [&](const auto& visit) {
    if (box.empty()) return;
    for (int k = 0; k < 8; ++k)
      visit(Vector3((k & 1) ? box.hi.x() : box.lo.x(), (k & 2) ? box.hi.y() : box.lo.y(),
                    (k & 4) ? box.hi.z() : box.lo.z()));
  };
  return framedPoints(view, axes, corners, aspect, margin);
}

Camera framed(const View& view, const ModelAxes& axes, const Scene& scene, double aspect,
              double margin, const std::optional<mesh::Box>& within) {
  const auto points = [&](const auto& visit) {
    visitPoints(scene, [&](const Vector3& p) {
      if (scene.clip && scene.clip->normal.dot(p - scene.clip->point) < 0.0) return;
      if (within && ((p - within->lo).minCoeff() < 0.0 || (within->hi - p).minCoeff() < 0.0))
        return;
      visit(p);
    });
  };
  return framedPoints(view, axes, points, aspect, margin);
}

ModelAxes guessedAxes(const mesh::Box& box, char up) {
  EC_REQUIRE(up == 'X' || up == 'Y' || up == 'Z');
  ModelAxes axes;
  const int u = up - 'X';
  axes.up = Vector3::Unit(u);
  const int a = (u + 1) % 3;
  const int b = (u + 2) % 3;
  const Vector3 size = box.empty() ? Vector3::Ones() : Vector3(box.hi - box.lo);
  axes.forward = Vector3::Unit(size(a) >= size(b) ? a : b);
  return axes;
}

bool isBeyondPicture(const Eigen::Matrix4f& toClip, const Eigen::Vector3f& lo,
                     const Eigen::Vector3f& hi) {
  std::array<int, 5> beyond{};
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector4f p =
        toClip * Eigen::Vector4f((k & 1) ? hi.x() : lo.x(), (k & 2) ? hi.y() : lo.y(),
                                 (k & 4) ? hi.z() : lo.z(), 1.0f);
    beyond[0] += p.x() > p.w();
    beyond[1] += p.x() < -p.w();
    beyond[2] += p.y() > p.w();
    beyond[3] += p.y() < -p.w();
    beyond[4] += p.z() < -p.w();
  }
  return std::ranges::max(beyond) == 8;
}

double pixelSize(const Camera& camera, int height) {
  return camera.fovDeg > 0.0 ? 2.0 * std::tan(0.5 * camera.fovDeg * kDegree) / height
                             : camera.orthoHeight / height;
}

std::optional<Projected> project(const Camera& camera, int width, int height,
                                 const Vector3& point) {
  const EyeAxes eye = eyeAxes(camera);
  const Vector3 from = point - camera.eye;
  const double depth = -from.dot(eye.back);
  if (camera.fovDeg > 0.0 && depth <= 0.0) return std::nullopt;
  const double pixel = pixelSize(camera, height) * (camera.fovDeg > 0.0 ? depth : 1.0);
  return Projected{
      {0.5 * width + from.dot(eye.right) / pixel, 0.5 * height - from.dot(eye.up) / pixel}, depth};
}

Ray rayThrough(const Camera& camera, int width, int height, const Eigen::Vector2d& pixel) {
  const EyeAxes eye = eyeAxes(camera);
  const double size = pixelSize(camera, height);
  const Vector3 aside =
      (pixel.x() - 0.5 * width) * size * eye.right + (0.5 * height - pixel.y()) * size * eye.up;
  if (camera.fovDeg > 0.0) return {camera.eye, (aside - eye.back).normalized()};
  return {camera.eye + aside, -eye.back};
}

Eigen::Matrix4d viewProjection(const Camera& camera, int width, int height, const mesh::Box& box,
                               const Vector3& origin, const Eigen::Vector2d& jitter) {
  const EyeAxes eye = eyeAxes(camera);
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  view.block<1, 3>(0, 0) = eye.right.transpose();
  view.block<1, 3>(1, 0) = eye.up.transpose();
  view.block<1, 3>(2, 0) = eye.back.transpose();
  view.block<3, 1>(0, 3) = view.block<3, 3>(0, 0) * (origin - camera.eye);

  double nearest = std::numeric_limits<double>::infinity();
  double farthest = -nearest;
  for (int k = 0; k < 8 && !box.empty(); ++k) {
    const Vector3 p((k & 1) ? box.hi.x() : box.lo.x(), (k & 2) ? box.hi.y() : box.lo.y(),
                    (k & 4) ? box.hi.z() : box.lo.z());
    const double depth = (camera.eye - p).dot(eye.back);
    nearest = std::min(nearest, depth);
    farthest = std::max(farthest, depth);
  }
  const double target = (camera.eye - camera.target).norm();
  if (!(nearest <= farthest)) nearest = farthest = target;
  const double slack = 0.02 * (farthest - nearest) + 1e-3 * target;
  double n = nearest - slack;
  double f = farthest + slack;

  const double aspect = static_cast<double>(width) / height;
  Eigen::Matrix4d projection = Eigen::Matrix4d::Zero();
  if (camera.fovDeg > 0.0) {
    f = std::max(f, 1e-6 * target);
    n = std::max(n, 2e-4 * f);
    const double t = std::tan(0.5 * camera.fovDeg * kDegree);
    projection(0, 0) = 1.0 / (t * aspect);
    projection(1, 1) = 1.0 / t;
    projection(2, 2) = -(f + n) / (f - n);
    projection(2, 3) = -2.0 * f * n / (f - n);
    projection(3, 2) = -1.0;
  } else {
    projection(0, 0) = 2.0 / (camera.orthoHeight * aspect);
    projection(1, 1) = 2.0 / camera.orthoHeight;
    projection(2, 2) = -2.0 / (f - n);
    projection(2, 3) = -(f + n) / (f - n);
    projection(3, 3) = 1.0;
  }
  Eigen::Matrix4d shift = Eigen::Matrix4d::Identity();
  shift(0, 3) = 2.0 * jitter.x() / width;
  shift(1, 3) = 2.0 * jitter.y() / height;
  return shift * projection * view;
}

}  // namespace ecorche::render
