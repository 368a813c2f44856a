#include <ecorche/core/contract.h>
#include <ecorche/mesh/spline_fit.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace ecorche::mesh {

namespace {

// A stroke as a poly-line of distinct points with the way along it.
struct PolyLine {
  std::vector<Vector3> points;
  std::vector<double> along;  // [m]

  explicit PolyLine(const std::vector<Vector3>& stroke) {
    for (const Vector3& p : stroke) {
      if (!points.empty() && p == points.back()) continue;
      along.push_back(points.empty() ? 0.0 : along.back() + (p - points.back()).norm());
      points.push_back(p);
    }
  }
  [[nodiscard]] double length() const { return along.back(); }
  [[nodiscard]] Vector3 at(double s) const {
    const auto above = std::ranges::upper_bound(along, s);
    if (above == along.end()) return points.back();
    const auto k = static_cast<std::size_t>(std::max<std::ptrdiff_t>(1, above - along.begin()));
    const double share = (s - along[k - 1]) / (along[k] - along[k - 1]);
    return (1.0 - share) * points[k - 1] + share * points[k];
  }
};

// What the spline shall meet: the stroke's own points, long gaps filled, each weighed by the
// stretch it stands for. The hand is slow in places and draws more points there; that must carry no
// weight.
struct Samples {
  std::vector<Vector3> point;
  std::vector<double> along;
  std::vector<double> weight;

  Samples(const PolyLine& line, double gap) {
    for (std::size_t k = 0; k < line.points.size(); ++k) {
      if (k > 0) {
        const double step = line.along[k] - line.along[k - 1];
        const int pieces = std::max(1, static_cast<int>(std::ceil(step / gap)));
        for (int i = 1; i < pieces; ++i) {
          const double share = static_cast<double>(i) / pieces;
          along.push_back(line.along[k - 1] + share * step);
          point.push_back((1.0 - share) * line.points[k - 1] + share * line.points[k]);
        }
      }
      along.push_back(line.along[k]);
      point.push_back(line.points[k]);
    }
    for (std::size_t k = 0; k < along.size(); ++k) {
      const double before = k > 0 ? along[k] - along[k - 1] : 0.0;
      const double after = k + 1 < along.size() ? along[k + 1] - along[k] : 0.0;
      weight.push_back(0.5 * (before + after));
    }
  }
};

bool neighboursDistinct(const std::vector<Vector3>& points, double apart) {
  for (std::size_t p = 1; p < points.size(); ++p) {
    if (!((points[p] - points[p - 1]).norm() > apart)) return false;
  }
  return true;
}

}  // namespace

std::vector<Vector3> fitSpline(const std::vector<Vector3>& stroke, int count) {
  EC_REQUIRE(count >= 2);
  const PolyLine line(stroke);
  EC_REQUIRE(line.points.size() >= 2);
  if (line.points.front() == line.points.back()) count = std::max(count, 3);
  if (static_cast<int>(line.points.size()) <= count) return line.points;

  // First guess: evenly along the stroke. Where a stroke runs back over itself these can coincide;
  // then its own points at even counts are apart.
  std::vector<Vector3> points;
  for (int p = 0; p < count; ++p) points.push_back(line.at(line.length() * p / (count - 1)));
  points.front() = line.points.front();
  points.back() = line.points.back();
  const double apart = 1e-6 * line.length();
  if (!neighboursDistinct(points, apart)) {
    for (std::size_t p = 0; p < points.size(); ++p) {
      points[p] = line.points[p * (line.points.size() - 1) / (points.size() - 1)];
    }
  }
  if (count == 2 || !neighboursDistinct(points, 0.0)) return points;

  // With knots frozen the spline is linear in its points (Spline::basis). Each round moves the
  // feet, then the inner points. Across the curve the step meets the samples in full; along it,
  // where the feet slide anyway, it only holds back a little [tangent distance minimisation: Wang,
  // Pottmann, Liu 2006]: tens of rounds where plain distances need hundreds.
  constexpr double kAlong = 0.1;
  const Samples samples(line, line.length() / (16.0 * count));
  const Eigen::Index inner = count - 2;
  std::vector<double> u;
  std::vector<Vector3> best = points;
  double bestError = std::numeric_limits<double>::infinity();
  for (int round = 0; round < 100; ++round) {
    const Spline curve(points);
    if (u.empty()) {
      for (double s : samples.along)
        u.push_back(curve.parameterAt(curve.length() * s / line.length()));
    }
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(3 * inner, 3 * inner);
    Eigen::VectorXd g = Eigen::VectorXd::Zero(3 * inner);
    double error = 0.0;
    for (std::size_t k = 1; k + 1 < samples.point.size(); ++k) {
      u[k] = curve.nearest(samples.point[k], u[k]);
      const Vector3 gap = samples.point[k] - curve.at(u[k]);
      const Vector3 t = curve.tangent(u[k]);
      const Eigen::VectorXd basis = curve.basis(u[k]).segment(1, inner);
      const Eigen::Matrix3d metric =
          samples.weight[k] * (Eigen::Matrix3d::Identity() - (1.0 - kAlong) * t * t.transpose());
      for (Eigen::Index p = 0; p < inner; ++p) {
        g.segment<3>(3 * p) += basis[p] * (metric * gap);
        for (Eigen::Index q = 0; q < inner; ++q)
          H.block<3, 3>(3 * p, 3 * q) += basis[p] * basis[q] * metric;
      }
      error += samples.weight[k] * gap.squaredNorm();
    }
    if (error < bestError) {
      bestError = error;
      best = points;
    }
    const Eigen::VectorXd step = H.ldlt().solve(g);
    if (!step.allFinite()) break;
    for (Eigen::Index p = 0; p < inner; ++p) {
      points[static_cast<std::size_t>(p) + 1] += step.segment<3>(3 * p);
    }
    if (!neighboursDistinct(points, apart)) break;
    if (step.norm() < 1e-10 * line.length()) break;
  }
  return best;
}

}  // namespace ecorche::mesh
