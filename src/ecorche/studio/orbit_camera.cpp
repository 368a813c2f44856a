#include <ecorche/render/light_rig.h>
#include <ecorche/studio/orbit_camera.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

constexpr double kRadians = std::numbers::pi / 180.0;
constexpr double kTurnPerPixel = 0.4;  // [degrees]
constexpr double kSteepest = 89.9;     // [degrees]
constexpr double kDollyStep = 0.88;

}  // namespace

void OrbitCamera::resize(int width, int height) {
  width_ = std::max(1, width);
  height_ = std::max(1, height);
}

void OrbitCamera::frame(const mesh::Box& box) {
  if (!(box.lo.array() <= box.hi.array()).all()) return;
  const render::View view{.azimuthDeg = azimuthDeg_,
                          .elevationDeg = elevationDeg_,
                          .fovDeg = parallel_ ? 0.0 : kFovDeg};
  const render::Camera camera =
      render::framed(view, axes_, box, static_cast<double>(width_) / height_, 0.06);
  target_ = camera.target;
  distance_ = parallel_ ? camera.orthoHeight / (2.0 * std::tan(0.5 * kFovDeg * kRadians))
                        : (camera.eye - camera.target).norm();
}

void OrbitCamera::lookFrom(double azimuthDeg, double elevationDeg) {
  azimuthDeg_ = azimuthDeg;
  elevationDeg_ = std::clamp(elevationDeg, -kSteepest, kSteepest);
}

void OrbitCamera::orbit(double dx, double dy) {
  azimuthDeg_ = std::remainder(azimuthDeg_ - kTurnPerPixel * dx, 360.0);
  elevationDeg_ = std::clamp(elevationDeg_ + kTurnPerPixel * dy, -kSteepest, kSteepest);
}

void OrbitCamera::pan(double dx, double dy) {
  const render::EyeAxes eye = render::eyeAxes(camera());
  const double pixel = pixelAt(target_);
  target_ += pixel * (-dx * eye.right + dy * eye.up);
}

void OrbitCamera::dolly(double steps, const Eigen::Vector2d& pixel) {
  const Vector3 before = placeLike(target_, pixel);
  distance_ *= std::pow(kDollyStep, steps);
  target_ += before - placeLike(target_, pixel);
}

Vector3 OrbitCamera::back() const {
  const Vector3 left = axes_.up.cross(axes_.forward);
  const double az = azimuthDeg_ * kRadians;
  const double el = elevationDeg_ * kRadians;
  return std::cos(el) * (std::cos(az) * axes_.forward + std::sin(az) * left) +
         std::sin(el) * axes_.up;
}

render::Camera OrbitCamera::camera() const {
  render::Camera out;
  out.target = target_;
  out.eye = target_ + distance_ * back();
  out.up = axes_.up;
  out.fovDeg = parallel_ ? 0.0 : kFovDeg;
  out.orthoHeight = 2.0 * distance_ * std::tan(0.5 * kFovDeg * kRadians);
  return out;
}

authoring::SightRay OrbitCamera::sight(const Eigen::Vector2d& pixel) const {
  const render::Camera c = camera();
  const render::EyeAxes eye = render::eyeAxes(c);
  const double x = pixel.x() - 0.5 * width_;
  const double y = 0.5 * height_ - pixel.y();
  const double size = render::pixelSize(c, height_);
  if (parallel_) return {c.eye + size * (x * eye.right + y * eye.up), -eye.back};
  return {c.eye, (size * (x * eye.right + y * eye.up) - eye.back).normalized()};
}

std::optional<Eigen::Vector2d> OrbitCamera::pixelOf(const Vector3& p) const {
  const auto seen = render::project(camera(), width_, height_, p);
  if (!seen) return std::nullopt;
  return seen->pixel;
}

double OrbitCamera::pixelAt(const Vector3& p) const {
  const render::Camera c = camera();
  const double size = render::pixelSize(c, height_);
  return parallel_ ? size : size * std::max(1e-9, (c.eye - p).dot(back()));
}

Vector3 OrbitCamera::placeLike(const Vector3& like, const Eigen::Vector2d& pixel) const {
  const authoring::SightRay ray = sight(pixel);
  const double toPlane = (like - ray.origin).dot(back());
  return ray.origin + toPlane / ray.direction.dot(back()) * ray.direction;
}

}  // namespace ecorche::studio
