#pragma once

#include <ecorche/domain/build_domain.h>
#include <ecorche/domain/carve.h>
#include <ecorche/domain/vertex_links.h>
#include <ecorche/mesh/surface_topology.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <set>

namespace ecorche::test {

/// Everything that a Domain promises, whatever it was made from.
inline void requireSound(const domain::Domain& d) {
  using namespace ecorche;
  REQUIRE(d.mesh.T.rows() > 0);
  CHECK(mesh::signedVolumes(d.mesh).minCoeff() > 0.0);
  const auto adjacency = mesh::tetAdjacency(d.mesh.T);
  CHECK(adjacency.nonManifoldFaces == 0);
  CHECK(adjacency.neighbours == d.neighbours);
  CHECK_FALSE(domain::firstSingularVertex(d.mesh, d.neighbours).has_value());
  CHECK(mesh::isClosed(d.boundaryF));
  CHECK(mesh::isManifold(d.boundaryF));
  CHECK(mesh::isOriented(d.boundaryF));
  REQUIRE(d.boundaryTag.size() == static_cast<std::size_t>(d.boundaryF.rows()));
  REQUIRE(d.boundaryTet.size() == static_cast<std::size_t>(d.boundaryF.rows()));
  CHECK(mesh::signedVolume(d.mesh.V, d.boundaryF) == Approx(d.volume).epsilon(1e-9));
  CHECK(mesh::signedVolumes(d.mesh).sum() == Approx(d.volume).epsilon(1e-12));
  // Skin vertices are those of skin faces, no more and no less
  std::vector<std::uint8_t> onSkin(static_cast<std::size_t>(d.mesh.V.rows()), 0);
  for (Eigen::Index f = 0; f < d.boundaryF.rows(); ++f) {
    if (d.boundaryTag[static_cast<std::size_t>(f)].kind != domain::BoundaryTag::Kind::Skin)
      continue;
    for (int k = 0; k < 3; ++k) onSkin[static_cast<std::size_t>(d.boundaryF(f, k))] = 1;
  }
  CHECK(onSkin == d.onSkin);
}

inline double areaOf(const domain::Domain& d, domain::BoundaryTag tag) {
  double area = 0.0;
  for (Eigen::Index f = 0; f < d.boundaryF.rows(); ++f) {
    if (d.boundaryTag[static_cast<std::size_t>(f)] != tag) continue;
    area += mesh::surfaceArea(d.mesh.V, d.boundaryF.row(f));
  }
  return area;
}

/// The largest distance of a vertex of the plane's faces from the plane.
inline double farthestFromPlane(const domain::Domain& d, std::int32_t index,
                                const domain::CutPlane& plane) {
  double far = 0.0;
  for (Eigen::Index f = 0; f < d.boundaryF.rows(); ++f) {
    if (d.boundaryTag[static_cast<std::size_t>(f)] !=
        domain::BoundaryTag{domain::BoundaryTag::Kind::CutPlane, index}) {
      continue;
    }
    for (int k = 0; k < 3; ++k) {
      const mesh::Vector3 p = d.mesh.V.row(d.boundaryF(f, k)).transpose();
      far = std::max(far, std::abs(plane.normal.dot(p - plane.point)));
    }
  }
  return far;
}

inline bool hasFinding(const Findings& findings, const std::string& kind) {
  for (const Finding& f : findings) {
    if (f.kind == kind) return true;
  }
  return false;
}

inline domain::Hole bone(mesh::SurfaceMesh mesh, std::string name, int index) {
  mesh.name = name;
  return {std::move(name), std::move(mesh), {domain::BoundaryTag::Kind::Bone, index}, true};
}

}  // namespace ecorche::test
