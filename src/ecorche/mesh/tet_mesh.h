#pragma once

#include <ecorche/mesh/types.h>

#include <vector>

namespace ecorche::mesh {

/// Positively oriented tetrahedra over shared vertices: (b−a)×(c−a)·(d−a) > 0.
struct TetMesh {
  Positions V;  ///< #V×3 [m]
  Tets T;       ///< #T×4
};

/// Neighbours across faces: N(t, k) is the tet that shares the face opposite corner k of t, -1 on
/// the boundary.
using TetNeighbours = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor>;  // #T×4

[[nodiscard]] double signedVolume(const Vector3& a, const Vector3& b, const Vector3& c,
                                  const Vector3& d);
[[nodiscard]] double signedVolume(const TetMesh& mesh, Eigen::Index tet);
[[nodiscard]] Eigen::VectorXd signedVolumes(const TetMesh& mesh);  // #T [m³]
/// Mean of the six edge lengths of every tet [m].
[[nodiscard]] Eigen::VectorXd meanEdgeLengths(const TetMesh& mesh);

/// What two tets share, found by sorting faces. Faces with three or more tets are counted, not
/// linked.
struct TetAdjacency {
  TetNeighbours neighbours;           ///< #T×4
  std::int64_t nonManifoldFaces = 0;  ///< faces that three or more tets claim
};
[[nodiscard]] TetAdjacency tetAdjacency(const Tets& T);

/// Faces with one tet, facing outward, in (tet, corner) order, and the tet each belongs to.
struct TetBoundary {
  Triangles F;
  std::vector<std::int32_t> tet;
};
[[nodiscard]] TetBoundary tetBoundary(const Tets& T, const TetNeighbours& neighbours);

/// Compressed vertex → tets list: tets of v are tet[first[v]] … tet[first[v+1]-1], ascending.
struct VertexTets {
  std::vector<std::int32_t> first;  ///< #V+1
  std::vector<std::int32_t> tet;
};
[[nodiscard]] VertexTets vertexTets(const Tets& T, Eigen::Index vertexCount);

/// Smallest and largest dihedral angle of every tet [degrees], #T×2.
[[nodiscard]] Eigen::MatrixX2d dihedralRangeDeg(const TetMesh& mesh);

}  // namespace ecorche::mesh
