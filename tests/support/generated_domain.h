#pragma once

#include <ecorche/domain/domain.h>

#include <cstdint>
#include <functional>

namespace ecorche::test {

/// Six tets per cell around the cell's diagonal [Kuhn 1960], positively oriented. Inner vertices
/// move by up to `jitter` cells in every direction (0.2 keeps all volumes positive).
struct Grid {
  Eigen::Array3i cells{8, 8, 8};
  mesh::Vector3 lo = mesh::Vector3::Zero();  ///< [m]
  mesh::Vector3 hi = mesh::Vector3::Ones();  ///< [m]
  double jitter = 0.0;                       ///< share of a cell
  std::uint64_t seed = 1;
  bool mirrored =
      false;  ///< diagonals point away from the middle of x and y: better corners on a disc
};
[[nodiscard]] mesh::TetMesh kuhnGrid(const Grid& grid);

/// Fills in what a domain derives from its tets: neighbours, boundary, skin vertices, volume, skin
/// diagonal.
/// @param tag  of a boundary face, given its centroid and outward unit normal
using FaceTagger = std::function<domain::BoundaryTag(const mesh::Vector3&, const mesh::Vector3&)>;
[[nodiscard]] domain::Domain domainOf(mesh::TetMesh mesh, const FaceTagger& tag);
[[nodiscard]] domain::BoundaryTag allSkin(const mesh::Vector3&, const mesh::Vector3&);

[[nodiscard]] domain::Domain boxDomain(const Grid& grid);

/// About the z axis from z = 0 to length, the side skin, the ends cut planes 0 and 1 (no skin
/// constraint).
/// @param cellsAcross  cells along a diameter
/// @param seed         of a jitter by a fifth of a cell; 0: none
[[nodiscard]] domain::Domain cylinderDomain(double radius, double length, int cellsAcross,
                                            std::uint64_t seed);

/// Between two spheres about the origin: the outer one skin, the inner one bone 0.
/// @param fineness  each face of an icosahedron becomes fineness² triangles; layers in proportion
[[nodiscard]] domain::Domain shellDomain(double inner, double outer, int fineness);

/// The domain moved: rotation, then scale, then translation.
[[nodiscard]] domain::Domain moved(const domain::Domain& domain, const Eigen::Matrix3d& rotation,
                                   double scale, const mesh::Vector3& translation);

}  // namespace ecorche::test
