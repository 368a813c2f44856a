#include <ecorche/engine/curve_room.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>

namespace ecorche::engine {

namespace {

using mesh::Vector3;

// Points in cubes of one size, asked for the nearest that somebody else owns
class Grid {
 public:
  explicit Grid(double cell) : cell_(cell) {}

  void add(const Vector3& p, int owner) { cells_[key(index(p))].push_back({p, owner}); }

  // Distance to the nearest point of another owner, looked for up to `reach`
  [[nodiscard]] double nearestOther(const Vector3& p, int owner, double reach) const {
    const Eigen::Vector3i centre = index(p);
    double best = reach;
    const int rings = static_cast<int>(std::ceil(reach / cell_));
    for (int ring = 0; ring <= rings && (ring - 1) * cell_ < best; ++ring) {
      for (int x = -ring; x <= ring; ++x) {
        for (int y = -ring; y <= ring; ++y) {
          const bool inside = std::abs(x) < ring && std::abs(y) < ring;
          for (int z = -ring; z <= ring; z += inside ? std::max(1, 2 * ring) : 1) {
            const auto cell = cells_.find(key(centre + Eigen::Vector3i(x, y, z)));
            if (cell == cells_.end()) continue;
            for (const Entry& e : cell->second) {
              if (e.owner != owner) best = std::min(best, (e.point - p).norm());
            }
          }
        }
      }
    }
    return best;
  }

 private:
  struct Entry {
    Vector3 point;
    int owner;
  };
  double cell_;
  std::unordered_map<std::int64_t, std::vector<Entry>> cells_;

  [[nodiscard]] Eigen::Vector3i index(const Vector3& p) const {
    return (p / cell_).array().floor().cast<int>();
  }
  static std::int64_t key(const Eigen::Vector3i& c) {
    constexpr std::int64_t kSpan = 1 << 20;
    return ((c.x() + kSpan) * (2 * kSpan) + (c.y() + kSpan)) * (2 * kSpan) + (c.z() + kSpan);
  }
};

// Two curves that touch at their ends do not make either muscle thin all along: a running median of
// five
std::vector<double> smoothed(const std::vector<double>& radius) {
  std::vector<double> out = radius;
  const auto count = static_cast<std::ptrdiff_t>(radius.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    std::vector<double> around(radius.begin() + std::max<std::ptrdiff_t>(0, i - 2),
                               radius.begin() + std::min(count, i + 3));
    const auto middle = around.begin() + static_cast<std::ptrdiff_t>(around.size() / 2);
    std::ranges::nth_element(around, middle);
    out[static_cast<std::size_t>(i)] = *middle;
  }
  return out;
}

/// Points of all curves, owned by their tissue.
Grid gridOf(const std::vector<tissue::CurveTissue>& tissues, double cell, double spacing) {
  Grid curves(cell);
  for (std::size_t t = 0; t < tissues.size(); ++t) {
    for (const auto& curve : tissues[t].curves) {
      for (const Vector3& p : curve.spline.sample(spacing).point)
        curves.add(p, static_cast<int>(t));
    }
  }
  return curves;
}

}  // namespace

std::vector<domain::WantedLength> lengthsBetweenCurves(
    const std::vector<tissue::CurveTissue>& tissues, double diagonal) {
  constexpr double kShare = 0.12;
  const double reach = 0.01 * diagonal;
  const double floor = 0.002 * diagonal;
  const double spacing = 0.001 * diagonal;
  const Grid curves = gridOf(tissues, reach, spacing);
  std::vector<domain::WantedLength> out;
  for (std::size_t t = 0; t < tissues.size(); ++t) {
    if (tissues[t].filler) continue;
    for (const auto& curve : tissues[t].curves) {
      for (const Vector3& p : curve.spline.sample(spacing).point) {
        const double apart = curves.nearestOther(p, static_cast<int>(t), reach);
        if (apart < reach) out.push_back({p, kShare * std::max(floor, apart)});
      }
    }
  }
  return out;
}

std::vector<domain::WantedLength> lengthsAlongCurves(
    const std::vector<tissue::CurveTissue>& tissues, const mesh::SurfaceMesh& skin) {
  constexpr double kTetsAcross = 8.0;
  const double diagonal = mesh::boundingBox(skin).diagonal();
  const double spacing = 0.004 * diagonal;
  const double reach = 0.15 * diagonal;
  // Where curves run together muscles are thin anyway
  const double floor = 0.002 * diagonal;
  constexpr int kSkin = -1;

  const Grid curves = gridOf(tissues, 0.02 * diagonal, spacing);
  Grid skinPoints(0.02 * diagonal);
  for (Eigen::Index v = 0; v < skin.V.rows(); ++v) skinPoints.add(skin.V.row(v).transpose(), kSkin);

  std::vector<domain::WantedLength> out;
  for (std::size_t t = 0; t < tissues.size(); ++t) {
    if (tissues[t].filler) continue;
    for (const auto& curve : tissues[t].curves) {
      const std::vector<Vector3> points = curve.spline.sample(spacing).point;
      std::vector<double> radius;
      for (const Vector3& p : points) {
        const double toCurve = 0.5 * curves.nearestOther(p, static_cast<int>(t), reach);
        // Fat keeps a share of the way to the skin
        const double toSkin = 0.7 * skinPoints.nearestOther(p, static_cast<int>(t), reach);
        radius.push_back(std::max(floor, std::min(toCurve, toSkin)));
      }
      radius = smoothed(radius);
      for (std::size_t k = 0; k < points.size(); ++k) {
        const double length = 2.0 * radius[k] / kTetsAcross;
        out.push_back({points[k], length});
        // The whole muscle wants it, not the curve alone: a cross of points towards its surface
        for (int axis = 0; axis < 3; ++axis) {
          for (const double side : {-0.6, 0.6})
            out.push_back({points[k] + side * radius[k] * Vector3::Unit(axis), length});
        }
      }
    }
  }
  return out;
}

}  // namespace ecorche::engine
