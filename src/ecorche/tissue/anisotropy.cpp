#include <ecorche/core/contract.h>
#include <ecorche/tissue/anisotropy.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ecorche::tissue {

using domain::BoundaryTag;
using mesh::Vector3;

namespace {

Vector3 across(const Vector3& v, const Vector3& tangent) { return v - v.dot(tangent) * tangent; }

// Where the skin is, seen from p: faces count with area / distance⁴, so the nearest decide, and the
// answer moves smoothly with p.
Vector3 towardsSkin(const domain::Domain& domain, const Vector3& p) {
  Vector3 sum = Vector3::Zero();
  const double floor = 1e-6 * domain.skinDiagonal;
  for (Eigen::Index f = 0; f < domain.boundaryF.rows(); ++f) {
    if (domain.boundaryTag[static_cast<std::size_t>(f)].kind != BoundaryTag::Kind::Skin) continue;
    const auto at = [&](int k) {
      return Vector3(domain.mesh.V.row(domain.boundaryF(f, k)).transpose());
    };
    const Vector3 a = at(0);
    const Vector3 to = (a + at(1) + at(2)) / 3.0 - p;
    const double r = std::max(to.norm(), floor);
    const double area = 0.5 * (at(1) - a).cross(at(2) - a).norm();
    sum += area / (r * r * r * r * r) * to;
  }
  return sum;
}

// e3 where the rotation is 0: to the skin, else out of the curve's own plane, else any
Vector3 restDirection(const domain::Domain& domain, const mesh::Spline& spline, double u) {
  const Vector3 t = spline.tangent(u);
  const Vector3 skin = towardsSkin(domain, spline.at(u));
  Vector3 e3 = across(skin, t);
  if (e3.norm() > 1e-3 * skin.norm()) return e3.normalized();
  const Vector3 chordMiddle = 0.5 * (spline.points().front() + spline.points().back());
  e3 = across(spline.at(u) - chordMiddle, t);
  if (e3.norm() > 1e-6 * spline.length()) return e3.normalized();
  Eigen::Index axis = 0;
  t.cwiseAbs().minCoeff(&axis);
  return across(Vector3::Unit(axis), t).normalized();
}

// The smallest rotation that takes tangent a to tangent b, applied to v
Vector3 transported(const Vector3& v, const Vector3& a, const Vector3& b) {
  const Vector3 moved = Eigen::Quaterniond::FromTwoVectors(a, b) * v;
  return across(moved, b).normalized();
}

}  // namespace

std::vector<Frame> curveFrames(const domain::Domain& domain, const mesh::Spline& spline,
                               double rotation, const std::vector<double>& parameters) {
  EC_REQUIRE(std::ranges::is_sorted(parameters));
  // Steps fine enough that a chain of smallest rotations is parallel transport, the asked-for
  // places among them
  constexpr int kStepsPerPoint = 32;
  const double middle = spline.parameterAt(0.5 * spline.length());
  std::vector<double> u = parameters;
  const int steps = static_cast<int>(spline.lastParameter()) * kStepsPerPoint;
  for (int k = 0; k <= steps; ++k) u.push_back(spline.lastParameter() * k / steps);
  u.push_back(middle);
  std::ranges::sort(u);
  u.erase(std::unique(u.begin(), u.end()), u.end());

  const auto start = static_cast<std::size_t>(std::ranges::find(u, middle) - u.begin());
  std::vector<Vector3> tangent;
  for (const double x : u) tangent.push_back(spline.tangent(x));
  std::vector<Vector3> e3(u.size());
  e3[start] = restDirection(domain, spline, middle);
  for (std::size_t k = start + 1; k < u.size(); ++k) {
    e3[k] = transported(e3[k - 1], tangent[k - 1], tangent[k]);
  }
  for (std::size_t k = start; k-- > 0;) e3[k] = transported(e3[k + 1], tangent[k + 1], tangent[k]);

  std::vector<Frame> frames;
  for (const double x : parameters) {
    const auto k = static_cast<std::size_t>(std::ranges::lower_bound(u, x) - u.begin());
    const Vector3 e2 = e3[k].cross(tangent[k]);
    Frame frame;
    frame.col(0) = tangent[k];
    frame.col(1) = std::cos(rotation) * e2 + std::sin(rotation) * e3[k];
    frame.col(2) = -std::sin(rotation) * e2 + std::cos(rotation) * e3[k];
    frames.push_back(frame);
  }
  return frames;
}

Eigen::Matrix3d logTensor(const Frame& frame, const Anisotropy& anisotropy) {
  return std::log(anisotropy.lambda2) * frame.col(1) * frame.col(1).transpose() +
         std::log(anisotropy.lambda3) * frame.col(2) * frame.col(2).transpose();
}

Eigen::Matrix3d tensorFromLog(const Eigen::Matrix3d& log, double lowest, double highest) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(log);
  const Eigen::Vector3d lambda =
      eigen.eigenvalues().cwiseMax(lowest).cwiseMin(highest).array().exp().matrix();
  return eigen.eigenvectors() * lambda.asDiagonal() * eigen.eigenvectors().transpose();
}

double crossCapacity(const Eigen::Matrix3d& tensor, const Vector3& tangent) {
  Eigen::Index axis = 0;
  tangent.cwiseAbs().minCoeff(&axis);
  const Vector3 a = across(Vector3::Unit(axis), tangent).normalized();
  const Vector3 b = tangent.cross(a);
  const double ab = a.dot(tensor * b);
  return std::sqrt(std::max(0.0, a.dot(tensor * a) * b.dot(tensor * b) - ab * ab));
}

}  // namespace ecorche::tissue
