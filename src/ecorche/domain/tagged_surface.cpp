#include <ecorche/domain/tagged_surface.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

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

TaggedSurface ordered(const TaggedSurface& surface) {
  std::vector<std::int32_t> byPlace(static_cast<std::size_t>(surface.V.rows()));
  std::iota(byPlace.begin(), byPlace.end(), 0);
  const auto place = [&](std::int32_t v) {
    return std::array{surface.V(v, 0), surface.V(v, 1), surface.V(v, 2)};
  };
  std::ranges::stable_sort(byPlace, std::less<>{}, place);
  TaggedSurface out;
  out.V.resize(surface.V.rows(), 3);
  std::vector<std::int32_t> fresh(byPlace.size());
  for (std::size_t i = 0; i < byPlace.size(); ++i) {
    fresh[static_cast<std::size_t>(byPlace[i])] = static_cast<std::int32_t>(i);
    out.V.row(static_cast<Eigen::Index>(i)) = surface.V.row(byPlace[i]);
  }
  // Corners, then the tag
  std::vector<std::array<std::int32_t, 4>> faces(surface.tag.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    auto& face = faces[f];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = surface.F(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(k));
      face[k] = fresh[static_cast<std::size_t>(v)];
    }
    std::rotate(face.begin(), std::min_element(face.begin(), face.begin() + 3), face.begin() + 3);
    face[3] = surface.tag[f];
  }
  std::sort(faces.begin(), faces.end());
  out.F.resize(surface.F.rows(), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    out.F.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1], faces[f][2];
    out.tag.push_back(faces[f][3]);
  }
  return out;
}

TaggedSurface compacted(const TaggedSurface& surface) {
  mesh::SurfaceMesh plain;
  plain.V = surface.V;
  plain.F = surface.F;
  plain = mesh::compacted(plain);
  return {std::move(plain.V), std::move(plain.F), surface.tag};
}

}  // namespace ecorche::domain
