#include <ecorche/tissue/nearest_boundary.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace ecorche::tissue {

using mesh::Vector3;

namespace {

Vector3 nearestOnSegment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 ab = b - a;
  const double square = ab.squaredNorm();
  const double s = square > 0.0 ? std::clamp((p - a).dot(ab) / square, 0.0, 1.0) : 0.0;
  return a + s * ab;
}

}  // namespace

Vector3 nearestOnTriangle(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  // The foot of the perpendicular where it falls inside, else the nearest point of an edge
  const Vector3 n = (b - a).cross(c - a);
  const double nn = n.squaredNorm();
  if (nn > 0.0) {
    const double wa = (c - b).cross(p - b).dot(n);
    const double wb = (a - c).cross(p - c).dot(n);
    const double wc = (b - a).cross(p - a).dot(n);
    if (wa >= 0.0 && wb >= 0.0 && wc >= 0.0) return p - ((p - a).dot(n) / nn) * n;
  }
  Vector3 best = nearestOnSegment(p, a, b);
  for (const Vector3& q : {nearestOnSegment(p, b, c), nearestOnSegment(p, c, a)}) {
    if ((p - q).squaredNorm() < (p - best).squaredNorm()) best = q;
  }
  return best;
}

BoundaryHit nearestOnBoundary(const domain::Domain& domain, const Vector3& p,
                              std::optional<domain::BoundaryTag::Kind> kind) {
  BoundaryHit hit;
  double best = std::numeric_limits<double>::infinity();
  for (Eigen::Index f = 0; f < domain.boundaryF.rows(); ++f) {
    if (kind && domain.boundaryTag[static_cast<std::size_t>(f)].kind != *kind) continue;
    const auto at = [&](int k) {
      return Vector3(domain.mesh.V.row(domain.boundaryF(f, k)).transpose());
    };
    const Vector3 q = nearestOnTriangle(p, at(0), at(1), at(2));
    const double square = (p - q).squaredNorm();
    if (square < best) {
      best = square;
      hit = {static_cast<std::int32_t>(f), q, 0.0};
    }
  }
  if (hit.face >= 0) hit.distance = std::sqrt(best);
  return hit;
}

}  // namespace ecorche::tissue
