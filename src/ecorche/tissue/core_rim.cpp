#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/core_rim.h>
#include <ecorche/tissue/well.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace ecorche::tissue {

using mesh::Vector3;

std::vector<WellPoint> rimPoints(const CurveWalker& walker, const domain::Domain& domain,
                                 const CoreSample& middle, const Vector3& centre, double rho) {
  // Across the tangent, from a corner of the tet, so that the rim turns with the model
  Vector3 across = Vector3::Zero();
  for (int k = 0; k < 4; ++k) {
    const Vector3 to = domain.mesh.V.row(domain.mesh.T(middle.tet, k)).transpose() - centre;
    const Vector3 candidate = to - to.dot(middle.tangent) * middle.tangent;
    if (candidate.squaredNorm() > across.squaredNorm()) across = candidate;
  }
  across.normalize();
  const Vector3 third = middle.tangent.cross(across);

  const int count = rimPointCount(rho, walker.meanEdges()[middle.tet]);
  std::vector<WellPoint> points;
  for (int k = 0; k < count; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / count;
    const Vector3 p = centre + rho * (std::cos(angle) * across + std::sin(angle) * third);
    const std::int32_t tet = walker.find(middle.tet, p);
    if (tet >= 0) points.push_back({p, tet});
  }
  if (points.empty()) points.push_back({centre, middle.tet});
  return points;
}

void addRimRows(const domain::Domain& domain, const CoreSample& middle,
                const std::vector<WellPoint>& points, double resistance,
                std::vector<CoreSample>& out) {
  const double weight = 1.0 / resistance;
  for (const WellPoint& point : points) {
    CoreSample sample = middle;
    sample.tet = point.tet;
    sample.barycentric = mesh::barycentric(domain.mesh, point.tet, point.p);
    sample.length = middle.length / static_cast<double>(points.size());
    sample.weight = weight * sample.length;
    out.push_back(sample);
  }
}

}  // namespace ecorche::tissue
