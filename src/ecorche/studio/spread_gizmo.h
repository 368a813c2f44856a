#pragma once

#include <ecorche/model/project.h>
#include <ecorche/studio/orbit_camera.h>
#include <ecorche/studio/session.h>

#include <optional>
#include <vector>

namespace ecorche::studio {

enum class SpreadPart : int { Lambda2, Lambda3, Ring };

/// Handles for how a muscle spreads across its curve [ABLSJ21 §3.7]: a ring around the middle of
/// the curve to turn, and a handle on each of the two axes for λ₂ and λ₃. A handle on the ring is
/// 1; its distance from the curve is the square root of λ, as the muscle's width is.
class SpreadGizmo {
 public:
  /// Of the selected muscle's selected (or first) curve; nothing where none is, where it is
  /// protected, or before the domain is there.
  [[nodiscard]] static std::optional<SpreadGizmo> of(const Session& session,
                                                     const OrbitCamera& camera);

  [[nodiscard]] const std::vector<mesh::Vector3>& ring() const { return ring_; }
  [[nodiscard]] std::vector<std::vector<mesh::Vector3>> axes() const;
  [[nodiscard]] std::vector<mesh::Vector3> handles() const;  ///< on e2 and on e3

  [[nodiscard]] std::optional<SpreadPart> under(const Eigen::Vector2d& pixel) const;

  /// What a drag of a part to a pixel makes of it; handles pulled onto the curve stop short.
  /// @param from  where the hand took it
  [[nodiscard]] model::Anisotropy dragged(SpreadPart part, const Eigen::Vector2d& from,
                                          const Eigen::Vector2d& to) const;

 private:
  OrbitCamera camera_;
  model::Anisotropy now_;
  mesh::Vector3 middle_ = mesh::Vector3::Zero();  // [m]
  Eigen::Matrix3d frame_;                         // tangent, e2, e3 with the rotation that it has
  double radius_ = 0.0;                           // of the ring [m]
  std::vector<mesh::Vector3> ring_;

  SpreadGizmo() = default;
  [[nodiscard]] std::optional<Eigen::Vector2d> across(const Eigen::Vector2d& pixel) const;
};

}  // namespace ecorche::studio
