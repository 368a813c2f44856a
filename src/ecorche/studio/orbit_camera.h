#pragma once

#include <ecorche/authoring/stroke.h>
#include <ecorche/render/views.h>

#include <Eigen/Core>

namespace ecorche::studio {

/// How near a hand has to be to what it takes hold of [pixels].
inline constexpr double kHandReach = 9.0;

/// An eye that a hand turns about a point. Pixels count from the top left of the view, in the same
/// units as `width` and `height`.
class OrbitCamera {
 public:
  void setAxes(const render::ModelAxes& axes) { axes_ = axes; }
  void resize(int width, int height);

  /// Fills the view with the box from where the eye stands now.
  void frame(const mesh::Box& box);
  /// Looks from there at what is in the middle now: 0° is the front, 90° the model's own left.
  void lookFrom(double azimuthDeg, double elevationDeg);
  void setParallel(bool parallel) { parallel_ = parallel; }

  /// A drag by so many pixels: the model turns with the hand.
  void orbit(double dx, double dy);
  /// What is in the middle moves with the hand.
  void pan(double dx, double dy);
  /// Nearer for steps above 0; what is under the pixel stays there.
  void dolly(double steps, const Eigen::Vector2d& pixel);

  [[nodiscard]] render::Camera camera() const;
  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }

  [[nodiscard]] authoring::SightRay sight(const Eigen::Vector2d& pixel) const;
  /// Where a point is seen; nothing behind the eye.
  [[nodiscard]] std::optional<Eigen::Vector2d> pixelOf(const mesh::Vector3& p) const;
  /// Length of a pixel at a point [m].
  [[nodiscard]] double pixelAt(const mesh::Vector3& p) const;
  /// The place under the pixel that is as far from the eye, along its line of sight, as `like`.
  [[nodiscard]] mesh::Vector3 placeLike(const mesh::Vector3& like,
                                        const Eigen::Vector2d& pixel) const;

 private:
  static constexpr double kFovDeg = 24.0;

  render::ModelAxes axes_;
  mesh::Vector3 target_ = mesh::Vector3::Zero();
  double distance_ = 3.0;  // [m]
  double azimuthDeg_ = 40.0;
  double elevationDeg_ = 12.0;
  bool parallel_ = false;
  int width_ = 1;
  int height_ = 1;

  [[nodiscard]] mesh::Vector3 back() const;  // unit, from the target to the eye
};

}  // namespace ecorche::studio
