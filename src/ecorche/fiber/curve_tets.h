#pragma once

#include <ecorche/mesh/tet_mesh.h>

#include <vector>

namespace ecorche::fiber {

/// A tet that a poly-line runs through.
struct TetOnCurve {
  std::int32_t tet = -1;                           ///< row of the mesh
  double length = 0.0;                             ///< of the line inside the tet [m], > 0
  mesh::Vector3 tangent = mesh::Vector3::UnitX();  ///< mean direction of the line inside, unit
};

/// Which of the given tets a poly-line runs through and how far, ascending. A line along a face
/// counts in both tets.
/// @param tets  rows of `mesh` to look at
[[nodiscard]] std::vector<TetOnCurve> tetsOnCurve(const mesh::TetMesh& mesh,
                                                  const std::vector<std::int32_t>& tets,
                                                  const std::vector<mesh::Vector3>& line);

/// Share of the length of poly-lines that lies in any of the given tets, shared faces counted once;
/// 1 where the lines have no length.
[[nodiscard]] double shareInside(const mesh::TetMesh& mesh, const std::vector<std::int32_t>& tets,
                                 const std::vector<std::vector<mesh::Vector3>>& lines);

}  // namespace ecorche::fiber
