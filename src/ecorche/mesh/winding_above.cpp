#include <ecorche/mesh/winding_above.h>

#include <Eigen/Geometry>

namespace ecorche::mesh {

namespace {

/// Twice the face's area along its normal.
Vector3 areaVector(const SurfaceMesh& mesh, Eigen::Index f) {
  const Vector3 a = mesh.V.row(mesh.F(f, 0)).transpose();
  const Vector3 b = mesh.V.row(mesh.F(f, 1)).transpose();
  const Vector3 c = mesh.V.row(mesh.F(f, 2)).transpose();
  return (b - a).cross(c - a);
}

}  // namespace

std::optional<int> windingAbove(const SurfaceQuery& query, const SurfaceMesh& mesh,
                                Eigen::Index face, double hair) {
  const Vector3 normal = areaVector(mesh, face).normalized();
  if (!(normal.norm() > 0.5)) return std::nullopt;
  const Vector3 middle =
      (mesh.V.row(mesh.F(face, 0)) + mesh.V.row(mesh.F(face, 1)) + mesh.V.row(mesh.F(face, 2)))
          .transpose() /
      3.0;
  for (const SurfaceQuery::Hit& hit : query.allHits(middle, normal)) {
    if (hit.t > hair) return query.windingNumber(middle + 0.5 * hit.t * normal);
  }
  return 0;
}

std::vector<Eigen::Index> largestFaces(const SurfaceMesh& mesh, const FaceComponents& patches) {
  std::vector<double> area(static_cast<std::size_t>(patches.count), -1.0);
  std::vector<Eigen::Index> out(area.size(), 0);
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    const auto p = static_cast<std::size_t>(patches.label[static_cast<std::size_t>(f)]);
    const double own = areaVector(mesh, f).norm();
    if (own <= area[p]) continue;
    area[p] = own;
    out[p] = f;
  }
  return out;
}

}  // namespace ecorche::mesh
