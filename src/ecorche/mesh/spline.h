#pragma once

#include <ecorche/mesh/types.h>

#include <vector>

namespace ecorche::mesh {

/// Centripetal Catmull–Rom spline through its control points [Yuksel et al. 2011], knots spaced by
/// the square root of the chord. Two points give a segment. End tangents come from control points
/// mirrored across the ends.
///
/// Parameters: `u` in [0, #points − 1], control point p sits at u = p exactly. Arc length [m] by
/// Gauss quadrature.
class Spline {
 public:
  Spline() = default;
  /// @param points  at least two, neighbours distinct (ContractError otherwise)
  explicit Spline(std::vector<Vector3> points);

  [[nodiscard]] const std::vector<Vector3>& points() const { return points_; }
  bool operator==(const Spline& other) const { return points_ == other.points_; }
  [[nodiscard]] double lastParameter() const { return static_cast<double>(points_.size()) - 1.0; }

  [[nodiscard]] Vector3 at(double u) const;
  [[nodiscard]] Vector3 derivative(double u) const;  ///< d/du, per unit of u
  [[nodiscard]] Vector3 tangent(double u) const;     ///< unit length

  [[nodiscard]] double length() const;  ///< [m]
  /// Arc length from the start to u [m].
  [[nodiscard]] double lengthTo(double u) const;
  /// Between two places of which the first comes first [m]; 0 otherwise. Cheaper the shorter.
  [[nodiscard]] double lengthBetween(double u0, double u1) const;
  /// The place with as much of the curve before it as behind it, between two others, to 1e-12 of
  /// the length.
  [[nodiscard]] double halfway(double u0, double u1) const;
  /// Inverse of lengthTo, to 1e-12 of the length.
  [[nodiscard]] double parameterAt(double arcLength) const;

  /// Values given at control points, linear in arc length between them [ABLSJ21 §3.2, our choice of
  /// interpolation].
  [[nodiscard]] double interpolate(const std::vector<double>& values, double u) const;

  /// Weights of the control points at u: at(u) = Σ_p basis(u)[p] · points()[p], exact while the
  /// knots stay. #points, sum 1.
  [[nodiscard]] Eigen::VectorXd basis(double u) const;

  /// Parameter of the point on the curve nearest to x; the curve is searched all along.
  [[nodiscard]] double nearest(const Vector3& x) const;
  /// The same by Gauss–Newton steps from u, kept only while they come closer.
  [[nodiscard]] double nearest(const Vector3& x, double u) const;

  /// Points along the curve no farther apart than `spacing`, with their parameters; ends and
  /// control points included.
  struct Samples {
    std::vector<double> u;
    std::vector<Vector3> point;
  };
  [[nodiscard]] Samples sample(double spacing) const;

 private:
  std::vector<Vector3> points_;
  std::vector<double> knots_;       // one more at either end than points_
  std::vector<Vector3> extended_;   // mirrored, points, mirrored
  std::vector<double> cumulative_;  // arc length at control points

  [[nodiscard]] double arc(double u0, double u1, int pieces = 4) const;
};

}  // namespace ecorche::mesh
