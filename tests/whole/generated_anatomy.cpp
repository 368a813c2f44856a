#include "whole/generated_anatomy.h"

#include <ecorche/core/files.h>
#include <ecorche/mesh/spline.h>
#include <ecorche/mesh/write_mesh.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <functional>
#include <numbers>
#include <random>

namespace ecorche::test {

using mesh::Vector3;

namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

// The standard's distributions differ between libraries; these do not
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53;
  }
  int from(int low, int high) {
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  bool chance(double p) { return between(0.0, 1.0) < p; }

 private:
  std::mt19937_64 engine_;
};

// A bent axis with a frame that does not spin about it
struct Axis {
  mesh::Spline spline;
  double length = 0.0;
  Vector3 across = Vector3::UnitX();  // nowhere along the axis

  explicit Axis(std::vector<Vector3> points) : spline(std::move(points)), length(spline.length()) {}
  [[nodiscard]] Vector3 at(double share) const {
    return spline.at(spline.parameterAt(share * length));
  }
  /// Point at an angle about the axis, so far from it.
  [[nodiscard]] Vector3 at(double share, double angle, double radius) const {
    const Vector3 t = spline.tangent(spline.parameterAt(share * length));
    const Vector3 u = (across - across.dot(t) * t).normalized();
    return at(share) + radius * (std::cos(angle) * u + std::sin(angle) * t.cross(u));
  }
};

/// Radius at a share of the axis and an angle about it [m].
using Profile = std::function<double(double share, double angle)>;

// Closed tube with round ends, facing outward. Rings stand close at the ends, where the radius goes
// to 0 like a circle.
mesh::SurfaceMesh tube(const Axis& axis, const Profile& radius, int rings, int segments) {
  mesh::SurfaceMesh out;
  out.V.resize(rings * segments + 2, 3);
  const auto share = [&](int ring) {
    return 0.5 - 0.5 * std::cos(std::numbers::pi * (ring + 1) / (rings + 1));
  };
  for (int r = 0; r < rings; ++r) {
    for (int s = 0; s < segments; ++s) {
      const double angle = kTurn * s / segments;
      out.V.row(r * segments + s) = axis.at(share(r), angle, radius(share(r), angle)).transpose();
    }
  }
  const int first = rings * segments, last = first + 1;
  out.V.row(first) = axis.at(0.0).transpose();
  out.V.row(last) = axis.at(1.0).transpose();
  std::vector<std::array<int, 3>> faces;
  for (int s = 0; s < segments; ++s) {
    const int next = (s + 1) % segments;
    faces.push_back({first, next, s});
    faces.push_back({last, (rings - 1) * segments + s, (rings - 1) * segments + next});
    for (int r = 0; r + 1 < rings; ++r) {
      const int a = r * segments + s, b = r * segments + next;
      faces.push_back({a, b, b + segments});
      faces.push_back({a, b + segments, a + segments});
    }
  }
  out.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    out.F.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1], faces[f][2];
  return out;
}

// Like a sphere at the ends, `shoulder` of the length deep
double roundEnds(double share, double shoulder) {
  const double x = std::min({share, 1.0 - share, shoulder}) / shoulder;
  return std::sqrt(std::max(0.0, 1.0 - (1.0 - x) * (1.0 - x)));
}

struct Limb {
  Axis axis;
  Profile radius;
};

Limb makeLimb(Dice& dice) {
  const double length = dice.between(0.15, 0.6);
  const double thickness = length * dice.between(0.14, 0.26);
  // Bent by at most so much that the tube does not meet itself
  const double bend = dice.between(0.0, 0.25) * length;
  const double direction = dice.between(0.0, kTurn);
  std::vector<Vector3> points;
  for (int k = 0; k <= 4; ++k) {
    const double s = k / 4.0;
    const double side = bend * 4.0 * s * (1.0 - s) + 0.03 * length * dice.between(-1.0, 1.0);
    points.emplace_back(side * std::cos(direction), side * std::sin(direction), length * s);
  }
  const double taper = dice.between(-0.4, 0.4), flat = dice.between(0.0, 0.25),
               bumps = dice.between(0.0, 0.12);
  const double phase = dice.between(0.0, kTurn);
  const int waves = dice.from(1, 3);
  Profile radius = [=](double share, double angle) {
    const double along =
        1.0 + taper * (0.5 - share) + bumps * std::sin(kTurn * waves * share + phase);
    const double around =
        1.0 + flat * std::cos(2.0 * angle + phase) + 0.5 * bumps * std::cos(3.0 * angle - phase);
    return thickness * along * around * roundEnds(share, 0.2);
  };
  return {Axis(std::move(points)), std::move(radius)};
}

struct GeneratedBone {
  Axis axis;
  double radius;
};

// A chain along the limb, or side by side
std::vector<GeneratedBone> makeBones(Dice& dice, const Limb& limb, GeneratedAnatomy& out) {
  const int count = dice.from(1, 4);
  const bool parallel = count > 1 && dice.chance(0.3);
  const double thin = limb.radius(0.5, 0.0);
  std::vector<GeneratedBone> bones;
  for (int b = 0; b < count; ++b) {
    const double radius = thin * dice.between(0.12, 0.25);
    double from = 0.1, to = 0.9, offset = 0.25 * thin * dice.between(0.0, 1.0),
           angle = dice.between(0.0, kTurn);
    if (parallel) {
      // As radius and ulna: as close as chance has it
      angle = kTurn * b / count;
      offset = thin * dice.between(0.15, 0.45);
      from += dice.between(0.0, 0.15);
      to -= dice.between(0.0, 0.15);
    } else {
      const double share = 0.8 / count;
      const double gap =
          dice.chance(0.35) ? -0.02 : dice.between(0.0, 0.06);  // heads in one another, or apart
      out.bonesTouch = out.bonesTouch || (gap < 0.0 && count > 1);
      from = 0.1 + share * b + gap;
      to = 0.1 + share * (b + 1) - gap;
    }
    std::vector<Vector3> points;
    for (int k = 0; k <= 2; ++k)
      points.push_back(limb.axis.at(from + (to - from) * k / 2.0, angle, offset));
    if (dice.chance(0.12)) {
      // One end comes out through the skin
      out.bonePokesOut = true;
      points.back() = limb.axis.at(to, angle, 1.25 * limb.radius(to, angle));
    }
    bones.push_back({Axis(std::move(points)), radius});
  }
  return bones;
}

model::Curve makeCurve(Dice& dice, const Limb& limb, const std::vector<GeneratedBone>& bones,
                       double angle) {
  const auto bone = [&] {
    return static_cast<std::size_t>(dice.from(0, static_cast<int>(bones.size()) - 1));
  };
  std::size_t start = bone(), end = bone();
  if (start > end) std::swap(start, end);
  const auto on = [&](std::size_t b, double share) {
    const GeneratedBone& at = bones[b];
    return at.axis.at(share, angle + dice.between(-0.3, 0.3), 0.97 * at.radius);
  };
  const double first = dice.between(0.15, 0.35), last = dice.between(0.65, 0.85);
  model::Curve curve;
  curve.points.push_back({on(start, first), 0.0});
  const Vector3 target = on(end, last);
  const int between = dice.from(1, 3);
  for (int k = 1; k <= between; ++k) {
    // Straight from end to end, pushed out into the flesh
    const double s = static_cast<double>(k) / (between + 1);
    const Vector3 straight = (1.0 - s) * curve.points.front().at + s * target;
    const double share = std::clamp(
        (straight.z() - limb.axis.at(0.0).z()) / (limb.axis.at(1.0).z() - limb.axis.at(0.0).z()),
        0.12, 0.88);
    const double turn = angle + dice.between(-0.25, 0.25);
    const Vector3 out =
        limb.axis.at(share, turn, dice.between(0.45, 0.75) * limb.radius(share, turn));
    curve.points.push_back({out, 0.0});
  }
  curve.points.push_back({target, 0.0});
  for (model::ControlPoint& point : curve.points) point.tissue = dice.between(0.7, 2.0);
  curve.start = {model::Support::On::Bone, fmt::format("bone {}", start)};
  curve.end = {model::Support::On::Bone, fmt::format("bone {}", end)};
  return curve;
}

}  // namespace

GeneratedAnatomy generateAnatomy(std::uint64_t seed, std::int64_t tets,
                                 const std::filesystem::path& folder) {
  Dice dice(seed);
  GeneratedAnatomy out;
  model::Project& p = out.project;
  p.folder = folder;
  p.name = fmt::format("seed {}", seed);
  p.settings.tets = tets;
  p.settings.fat = dice.chance(0.1) ? 0.0 : dice.between(0.02, 0.4);

  const Limb limb = makeLimb(dice);
  REQUIRE(mesh::writeObj(tube(limb.axis, limb.radius, 30, 20), folder / "skin.obj"));
  p.skin.file = "skin.obj";
  const std::vector<GeneratedBone> bones = makeBones(dice, limb, out);
  for (std::size_t b = 0; b < bones.size(); ++b) {
    const GeneratedBone& bone = bones[b];
    const double shoulder = std::min(0.5, bone.radius / bone.axis.length);
    const Profile radius = [&](double share, double) {
      return bone.radius * roundEnds(share, shoulder);
    };
    const std::string file = fmt::format("bone-{}.obj", b);
    REQUIRE(mesh::writeObj(tube(bone.axis, radius, 16, 10), folder / file));
    p.bones.push_back({fmt::format("bone {}", b), {file, "", {}}});
  }

  const int count = dice.from(1, 5);
  for (int m = 0; m < count; ++m) {
    model::Tissue tissue;
    tissue.name = fmt::format("muscle {}", m);
    const int heads = dice.chance(0.2) ? 2 : 1;
    for (int h = 0; h < heads; ++h) {
      const double angle = kTurn * (m + 0.4 * h + dice.between(-0.15, 0.15)) / count;
      tissue.curves.push_back(makeCurve(dice, limb, bones, angle));
    }
    if (dice.chance(0.2))
      tissue.anisotropy = {dice.between(0.3, 3.0), dice.between(0.3, 3.0), dice.between(-1.5, 1.5)};
    if (dice.chance(0.2)) tissue.coreRadius = limb.axis.length * dice.between(0.001, 0.01);
    if (dice.chance(0.1)) tissue.kind = model::Tissue::Kind::Filler;
    p.tissues.push_back(std::move(tissue));
  }
  if (dice.chance(0.15)) {
    p.cutPlanes.push_back(
        {"cut", model::CutPlane::Kind::Region, limb.axis.at(0.5), Vector3::UnitY()});
  }
  return out;
}

}  // namespace ecorche::test
