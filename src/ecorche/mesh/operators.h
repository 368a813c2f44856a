#pragma once

#include <ecorche/mesh/tet_mesh.h>

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

namespace ecorche::mesh {

/// Gradients of the four barycentric coordinates of a tet, one per row [1/m]; rows add up to zero.
/// The gradient of the linear function with values f at the corners is Gᵀ f.
///
/// @param tet  positively oriented and of positive volume
[[nodiscard]] Eigen::Matrix<double, 4, 3> barycentricGradients(const TetMesh& mesh,
                                                               Eigen::Index tet);

/// Barycentric coordinates of p: positive inside, negative behind the face opposite to a corner,
/// sum 1.
[[nodiscard]] Eigen::Vector4d barycentric(const TetMesh& mesh, Eigen::Index tet, const Vector3& p);

/// A quarter of the volume of the tets around each vertex [m³], #V.
[[nodiscard]] Eigen::VectorXd lumpedMass(const TetMesh& mesh);

/// The six entries that each tet adds to the stiffness matrix K = Gᵀ M A G, edge by edge as in
/// kTetEdge [m]: k_ij = V ∇λ_i · A ∇λ_j. Diagonals follow, since rows add up to zero.
struct EdgeStiffness {
  std::vector<std::array<double, 6>> k;  ///< #T
  /// Tets so flat that 1/V would drown the others in rounding: their volume was taken as kFlattest
  /// · (mean edge)³, which keeps their part symmetric, positive semidefinite and blind to
  /// constants.
  std::vector<std::int32_t> flattened;
};

/// A volume below this many cubed mean edges is a sliver; a regular tet has 0.118 [unitless].
inline constexpr double kFlattest = 1e-6;

/// Isotropic: the cotangent Laplacian.
[[nodiscard]] EdgeStiffness edgeStiffness(const TetMesh& mesh);
/// Anisotropic: A(t) is a symmetric positive definite tensor per tet [unitless].
[[nodiscard]] EdgeStiffness edgeStiffness(const TetMesh& mesh, std::span<const Eigen::Matrix3d> A);

/// What one tet adds, edge by edge.
/// @param A  as above
[[nodiscard]] std::array<double, 6> edgeStiffness(const TetMesh& mesh, Eigen::Index tet,
                                                  const Eigen::Matrix3d& A);

/// Lower triangle, column by column, of any matrix that couples vertices of a common tet. It
/// depends on connectivity and on which vertices are fixed; values come and go.
///
/// Row r of the matrix is vertex[r]; entries of column r are index[first[r]] … index[first[r+1]−1],
/// ascending, the diagonal first.
struct StiffnessPattern {
  std::vector<std::int32_t> row;     ///< #V row of each vertex, -1 where it is fixed
  std::vector<std::int32_t> vertex;  ///< #rows, ascending
  std::vector<std::int32_t> first;   ///< #rows+1
  std::vector<std::int32_t> index;   ///< #entries
  std::vector<std::array<std::int32_t, 6>>
      edgeSlot;  ///< #T entry of each edge, -1 where an end is fixed
  VertexTets vertexTets;

  [[nodiscard]] std::int32_t rowCount() const { return static_cast<std::int32_t>(vertex.size()); }
  [[nodiscard]] std::size_t entryCount() const { return index.size(); }
  [[nodiscard]] std::int32_t diagonal(std::int32_t r) const {
    return first[static_cast<std::size_t>(r)];
  }
};

/// @param fixed  #V, not zero where the vertex has no row
[[nodiscard]] StiffnessPattern stiffnessPattern(const TetMesh& mesh,
                                                const std::vector<std::uint8_t>& fixed);

/// A pattern row by row, both triangles, without the diagonal.
struct NeighbourRows {
  std::vector<std::int32_t> first;      ///< #rows+1
  std::vector<std::int32_t> neighbour;  ///< row of each entry's column
  std::vector<std::int32_t> slot;       ///< where its value lies among the pattern's entries
};
[[nodiscard]] NeighbourRows neighbourRows(const StiffnessPattern& pattern);

/// Values of K on the pattern, #entries. Column by column in parallel, tets ascending: the same
/// bytes on any number of threads.
[[nodiscard]] std::vector<double> assembleStiffness(const TetMesh& mesh,
                                                    const StiffnessPattern& pattern,
                                                    const EdgeStiffness& stiffness);

}  // namespace ecorche::mesh
