#include <ecorche/studio/spread_gizmo.h>
#include <ecorche/tissue/anisotropy.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

constexpr double kRadius = 52.0;  // of the ring [pixels]
constexpr double kLeast = 0.05;   // λ
constexpr double kMost = 20.0;
constexpr int kRingSteps = 72;

// Of the muscle's width along an axis, over that of a round one
double reachOf(double lambda) { return std::sqrt(lambda); }

}  // namespace

std::optional<SpreadGizmo> SpreadGizmo::of(const Session& session, const OrbitCamera& camera) {
  const model::Tissue* tissue = session.selectedTissue();
  if (tissue == nullptr || !tissue->hasCurves() || tissue->curves.empty() || tissue->isProtected ||
      !session.domain())
    return std::nullopt;
  const auto curve = static_cast<std::size_t>(std::max(0, session.selection().curve));
  const mesh::Spline spline = model::splineOf(tissue->curves[curve]);
  const double u = spline.parameterAt(0.5 * spline.length());

  SpreadGizmo out;
  out.camera_ = camera;
  out.now_ = tissue->anisotropy;
  out.middle_ = spline.at(u);
  out.frame_ =
      tissue::curveFrames(session.domain()->domain, spline, out.now_.rotation, {u}).front();
  out.radius_ = kRadius * camera.pixelAt(out.middle_);
  for (int k = 0; k <= kRingSteps; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kRingSteps;
    out.ring_.emplace_back(out.middle_ + out.radius_ * (std::cos(angle) * out.frame_.col(1) +
                                                        std::sin(angle) * out.frame_.col(2)));
  }
  return out;
}

std::vector<Vector3> SpreadGizmo::handles() const {
  return {middle_ + radius_ * reachOf(now_.lambda2) * frame_.col(1),
          middle_ + radius_ * reachOf(now_.lambda3) * frame_.col(2)};
}

std::vector<std::vector<Vector3>> SpreadGizmo::axes() const {
  const std::vector<Vector3> ends = handles();
  return {{Vector3(2.0 * middle_ - ends[0]), ends[0]}, {Vector3(2.0 * middle_ - ends[1]), ends[1]}};
}

std::optional<SpreadPart> SpreadGizmo::under(const Eigen::Vector2d& pixel) const {
  const auto near = [&](const Vector3& p) {
    const auto seen = camera_.pixelOf(p);
    return seen && (*seen - pixel).norm() <= kHandReach;
  };
  const std::vector<Vector3> ends = handles();
  if (near(ends[0])) return SpreadPart::Lambda2;
  if (near(ends[1])) return SpreadPart::Lambda3;
  for (const Vector3& p : ring_)
    if (near(p)) return SpreadPart::Ring;
  return std::nullopt;
}

// The place under the pixel in the ring's plane, along e2 and e3; nothing where that is seen from
// its edge.
std::optional<Eigen::Vector2d> SpreadGizmo::across(const Eigen::Vector2d& pixel) const {
  const authoring::SightRay sight = camera_.sight(pixel);
  const Vector3 tangent = frame_.col(0);
  const double slope = sight.direction.dot(tangent);
  if (std::abs(slope) < 0.05) return std::nullopt;
  const Vector3 at =
      sight.origin + sight.direction * ((middle_ - sight.origin).dot(tangent) / slope) - middle_;
  return Eigen::Vector2d(at.dot(frame_.col(1)), at.dot(frame_.col(2)));
}

model::Anisotropy SpreadGizmo::dragged(SpreadPart part, const Eigen::Vector2d& from,
                                       const Eigen::Vector2d& to) const {
  model::Anisotropy out = now_;
  if (part == SpreadPart::Ring) {
    const auto a = across(from);
    const auto b = across(to);
    double turn = 0.0;
    if (a && b && a->norm() > 0.0 && b->norm() > 0.0) {
      turn = std::atan2(b->y(), b->x()) - std::atan2(a->y(), a->x());
    } else {
      // Seen from its edge: a hand's way of one radius is one radian
      turn = (to.x() - from.x()) / kRadius;
    }
    out.rotation = std::remainder(out.rotation + turn, 2.0 * std::numbers::pi);
    return out;
  }
  // Along the axis as it is seen: works also where the plane is seen from its edge
  const Vector3 axis = frame_.col(part == SpreadPart::Lambda2 ? 1 : 2);
  const auto centre = camera_.pixelOf(middle_);
  const auto tip = camera_.pixelOf(middle_ + radius_ * axis);
  if (!centre || !tip) return out;
  const Eigen::Vector2d way = *tip - *centre;
  if (way.norm() < 2.0) return out;  // it points at the eye
  const double reach = std::max(0.0, (to - *centre).dot(way) / way.squaredNorm());
  (part == SpreadPart::Lambda2 ? out.lambda2 : out.lambda3) =
      std::clamp(reach * reach, kLeast, kMost);
  return out;
}

}  // namespace ecorche::studio
