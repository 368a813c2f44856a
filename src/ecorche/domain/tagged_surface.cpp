#include <ecorche/domain/tagged_surface.h>

#include <cmath>

namespace ecorche::domain {

TaggedSurface tagged(const mesh::SurfaceMesh& mesh, BoundaryTag tag) {
  return {mesh.V, mesh.F,
          std::vector<std::int32_t>(static_cast<std::size_t>(mesh.F.rows()), packed(tag))};
}

mesh::SurfaceMesh facesOf(const TaggedSurface& surface, std::int32_t tag) {
  mesh::SurfaceMesh part;
  part.V = surface.V;
  part.F.resize(surface.F.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f) {
    if (surface.tag[static_cast<std::size_t>(f)] == tag) part.F.row(count++) = surface.F.row(f);
  }
  part.F.conservativeResize(count, 3);
  return mesh::compacted(part);
}

mesh::Vector3 ontoPlane(const CutPlane& plane, mesh::Vector3 p) {
  p -= plane.normal.dot(p - plane.point) * plane.normal;
  // Along an axis the coordinate itself, so that no rounding is left
  for (int k = 0; k < 3; ++k) {
    if (std::abs(plane.normal[k]) == 1.0) p[k] = plane.point[k];
  }
  return p;
}

TaggedSurface compacted(const TaggedSurface& surface) {
  mesh::SurfaceMesh plain;
  plain.V = surface.V;
  plain.F = surface.F;
  plain = mesh::compacted(plain);
  return {std::move(plain.V), std::move(plain.F), surface.tag};
}

}  // namespace ecorche::domain
