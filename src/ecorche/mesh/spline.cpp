#include <ecorche/core/contract.h>
#include <ecorche/mesh/spline.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ecorche::mesh {

Spline::Spline(std::vector<Vector3> points) : points_(std::move(points)) {
  EC_REQUIRE(points_.size() >= 2);
  for (std::size_t p = 1; p < points_.size(); ++p) EC_REQUIRE(points_[p] != points_[p - 1]);

  extended_.push_back(2.0 * points_.front() - points_[1]);
  extended_.insert(extended_.end(), points_.begin(), points_.end());
  extended_.push_back(2.0 * points_.back() - points_[points_.size() - 2]);

  knots_.push_back(0.0);
  for (std::size_t p = 1; p < extended_.size(); ++p) {
    knots_.push_back(knots_.back() + std::sqrt((extended_[p] - extended_[p - 1]).norm()));
  }
  cumulative_.push_back(0.0);
  for (std::size_t p = 1; p < points_.size(); ++p) {
    cumulative_.push_back(cumulative_.back() +
                          arc(static_cast<double>(p) - 1.0, static_cast<double>(p)));
  }
}

namespace {

// Segment between control points p and p+1 as Barry and Goldman's pyramid; s in [0, 1].
struct Segment {
  const Vector3* P;  // four points
  const double* t;   // their knots
  double s;

  Vector3 value(Vector3* derivative) const {
    const double x = t[1] + s * (t[2] - t[1]);
    const auto mix = [&](const Vector3& a, const Vector3& b, double ta, double tb) {
      return Vector3(((tb - x) * a + (x - ta) * b) / (tb - ta));
    };
    const Vector3 A1 = mix(P[0], P[1], t[0], t[1]);
    const Vector3 A2 = mix(P[1], P[2], t[1], t[2]);
    const Vector3 A3 = mix(P[2], P[3], t[2], t[3]);
    const Vector3 B1 = mix(A1, A2, t[0], t[2]);
    const Vector3 B2 = mix(A2, A3, t[1], t[3]);
    if (derivative != nullptr) {
      const Vector3 dA1 = (P[1] - P[0]) / (t[1] - t[0]);
      const Vector3 dA2 = (P[2] - P[1]) / (t[2] - t[1]);
      const Vector3 dA3 = (P[3] - P[2]) / (t[3] - t[2]);
      const Vector3 dB1 = (A2 - A1) / (t[2] - t[0]) + mix(dA1, dA2, t[0], t[2]);
      const Vector3 dB2 = (A3 - A2) / (t[3] - t[1]) + mix(dA2, dA3, t[1], t[3]);
      *derivative = ((B2 - B1) / (t[2] - t[1]) + mix(dB1, dB2, t[1], t[2])) * (t[2] - t[1]);
    }
    return mix(B1, B2, t[1], t[2]);
  }
};

std::pair<std::size_t, double> locate(double u, std::size_t pointCount) {
  const double clamped = std::clamp(u, 0.0, static_cast<double>(pointCount) - 1.0);
  const auto p = std::min(static_cast<std::size_t>(clamped), pointCount - 2);
  return {p, clamped - static_cast<double>(p)};
}

}  // namespace

Vector3 Spline::at(double u) const {
  const auto [p, s] = locate(u, points_.size());
  if (s == 0.0) return points_[p];
  if (s == 1.0) return points_[p + 1];
  return Segment{&extended_[p], &knots_[p], s}.value(nullptr);
}

Vector3 Spline::derivative(double u) const {
  const auto [p, s] = locate(u, points_.size());
  Vector3 d;
  (void)Segment{&extended_[p], &knots_[p], s}.value(&d);
  return d;
}

Vector3 Spline::tangent(double u) const {
  const Vector3 d = derivative(u);
  const double length = d.norm();
  if (length > 0.0) return d / length;
  const auto [p, s] = locate(u, points_.size());
  return (points_[p + 1] - points_[p]).normalized();
}

double Spline::arc(double u0, double u1, int pieces) const {
  // Ten-point Gauss–Legendre: on quarters ten digits and more but in cusps
  static constexpr std::array<double, 5> kX = {0.1488743389816312, 0.4333953941292472,
                                               0.6794095682990244, 0.8650633666889845,
                                               0.9739065285171717};
  static constexpr std::array<double, 5> kW = {0.2955242247147529, 0.2692667193099963,
                                               0.2190863625159820, 0.1494513491505806,
                                               0.0666713443086881};
  double sum = 0.0;
  for (int piece = 0; piece < pieces; ++piece) {
    const double a = u0 + (u1 - u0) * piece / pieces;
    const double b = u0 + (u1 - u0) * (piece + 1) / pieces;
    for (std::size_t k = 0; k < kX.size(); ++k) {
      const double h = 0.5 * (b - a);
      const double m = 0.5 * (a + b);
      sum += kW[k] * h * (derivative(m - h * kX[k]).norm() + derivative(m + h * kX[k]).norm());
    }
  }
  return sum;
}

double Spline::length() const { return cumulative_.empty() ? 0.0 : cumulative_.back(); }

double Spline::lengthTo(double u) const {
  const auto [p, s] = locate(u, points_.size());
  if (s == 0.0) return cumulative_[p];
  return cumulative_[p] + arc(static_cast<double>(p), static_cast<double>(p) + s);
}

double Spline::lengthBetween(double u0, double u1) const {
  if (!(u1 > u0)) return 0.0;
  const auto [p, s] = locate(u0, points_.size());
  const auto [q, t] = locate(u1, points_.size());
  if (p == q) {
    const int pieces = std::max(1, static_cast<int>(std::ceil(8.0 * (t - s))));
    return arc(static_cast<double>(p) + s, static_cast<double>(p) + t, pieces);
  }
  return lengthTo(u1) - lengthTo(u0);
}

double Spline::halfway(double u0, double u1) const {
  const double half = 0.5 * lengthBetween(u0, u1);
  double lo = u0;
  double hi = u1;
  double u = 0.5 * (u0 + u1);
  for (int step = 0; step < 50; ++step) {
    const double error = lengthBetween(u0, u) - half;
    if (std::abs(error) <= 1e-12 * length()) break;
    (error > 0.0 ? hi : lo) = u;
    const double speed = derivative(u).norm();
    double next = speed > 0.0 ? u - error / speed : lo;
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    u = next;
  }
  return u;
}

double Spline::parameterAt(double arcLength) const {
  const double target = std::clamp(arcLength, 0.0, length());
  const auto above = std::ranges::lower_bound(cumulative_, target);
  if (above == cumulative_.begin()) return 0.0;
  const auto p = static_cast<std::size_t>(above - cumulative_.begin()) - 1;
  if (*above == target) return static_cast<double>(p) + 1.0;

  // Newton on the monotone length, kept inside its bracket
  double lo = static_cast<double>(p);
  double hi = lo + 1.0;
  double u = lo + (target - cumulative_[p]) / (cumulative_[p + 1] - cumulative_[p]);
  for (int step = 0; step < 50; ++step) {
    const double error = lengthTo(u) - target;
    if (std::abs(error) <= 1e-12 * length()) break;
    (error > 0.0 ? hi : lo) = u;
    const double speed = derivative(u).norm();
    double next = speed > 0.0 ? u - error / speed : lo;
    if (!(next > lo && next < hi)) next = 0.5 * (lo + hi);
    u = next;
  }
  return u;
}

double Spline::interpolate(const std::vector<double>& values, double u) const {
  EC_REQUIRE_EQ(values.size(), points_.size());
  const auto [p, s] = locate(u, points_.size());
  if (s == 0.0 || values[p] == values[p + 1]) return values[p];
  const double share = (lengthTo(u) - cumulative_[p]) / (cumulative_[p + 1] - cumulative_[p]);
  return (1.0 - share) * values[p] + share * values[p + 1];
}

double Spline::nearest(const Vector3& x, double u) const {
  double distance = (at(u) - x).squaredNorm();
  for (int step = 0; step < 50; ++step) {
    const Vector3 d = derivative(u);
    const double next = std::clamp(u - d.dot(at(u) - x) / d.squaredNorm(), 0.0, lastParameter());
    const double closer = (at(next) - x).squaredNorm();
    if (!(closer < distance)) break;
    u = next;
    distance = closer;
  }
  return u;
}

double Spline::nearest(const Vector3& x) const {
  // A segment hardly turns within a sixteenth of itself, so the best sample lies in the right
  // valley
  constexpr int kPerSegment = 16;
  double best = 0.0;
  double bestDistance = std::numeric_limits<double>::infinity();
  const int count = kPerSegment * static_cast<int>(points_.size() - 1);
  for (int k = 0; k <= count; ++k) {
    const double u = static_cast<double>(k) / kPerSegment;
    const double distance = (at(u) - x).squaredNorm();
    if (distance < bestDistance) {
      bestDistance = distance;
      best = u;
    }
  }
  return nearest(x, best);
}

Spline::Samples Spline::sample(double spacing) const {
  EC_REQUIRE(spacing > 0.0);
  Samples out;
  for (std::size_t p = 0; p + 1 < points_.size(); ++p) {
    const double piece = cumulative_[p + 1] - cumulative_[p];
    const int steps = std::max(1, static_cast<int>(std::ceil(piece / spacing)));
    for (int k = 0; k < steps; ++k) {
      const double u =
          k == 0 ? static_cast<double>(p) : parameterAt(cumulative_[p] + piece * k / steps);
      out.u.push_back(u);
      out.point.push_back(at(u));
    }
  }
  out.u.push_back(lastParameter());
  out.point.push_back(points_.back());
  return out;
}

Eigen::VectorXd Spline::basis(double u) const {
  const auto [p, s] = locate(u, points_.size());
  const double* const t = &knots_[p];
  const double x = t[1] + s * (t[2] - t[1]);

  // The same pyramid as Segment::value, on the weights of the four points in place of the points
  using Weights = Eigen::Vector4d;
  const auto mix = [&](const Weights& a, const Weights& b, double ta, double tb) {
    return Weights(((tb - x) * a + (x - ta) * b) / (tb - ta));
  };
  std::array<Weights, 4> unit;
  for (int k = 0; k < 4; ++k) unit[static_cast<std::size_t>(k)] = Weights::Unit(k);
  const Weights A1 = mix(unit[0], unit[1], t[0], t[1]);
  const Weights A2 = mix(unit[1], unit[2], t[1], t[2]);
  const Weights A3 = mix(unit[2], unit[3], t[2], t[3]);
  const Weights B1 = mix(A1, A2, t[0], t[2]);
  const Weights B2 = mix(A2, A3, t[1], t[3]);
  const Weights C = mix(B1, B2, t[1], t[2]);

  // Extended point e is control point e − 1; those past the ends are 2·first − second and 2·last −
  // last but one
  const auto last = static_cast<Eigen::Index>(points_.size()) - 1;
  Eigen::VectorXd out = Eigen::VectorXd::Zero(last + 1);
  for (int k = 0; k < 4; ++k) {
    const Eigen::Index e = static_cast<Eigen::Index>(p) + k - 1;
    if (e < 0) {
      out[0] += 2.0 * C[k];
      out[1] -= C[k];
    } else if (e > last) {
      out[last] += 2.0 * C[k];
      out[last - 1] -= C[k];
    } else {
      out[e] += C[k];
    }
  }
  return out;
}

}  // namespace ecorche::mesh
