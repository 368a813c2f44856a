#pragma once

#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/mesh/tet_mesh.h>

#include <cstdint>
#include <vector>

namespace ecorche::mesh {

/// Which tet holds a point: a uniform grid over the mesh's box, each cell with the tets whose boxes
/// meet it.
///
/// Built once in O(#T); a question looks at one cell. Keeps a reference to the mesh, which must
/// outlive it.
class TetLocator {
 public:
  explicit TetLocator(const TetMesh& mesh);

  /// The tet that holds p, -1 outside. On shared faces the tet where p lies deepest, then the
  /// lowest id. A point that rounding puts outside (barycentric coordinate above −1e-10) is inside.
  [[nodiscard]] std::int32_t locate(const Vector3& p) const;

 private:
  const TetMesh& mesh_;
  Box box_;
  Vector3 perCell_ = Vector3::Zero();  // cells per metre
  Eigen::Array3i size_ = Eigen::Array3i::Zero();
  std::vector<std::int64_t> first_;  // #cells+1
  std::vector<std::int32_t> tet_;    // ascending within a cell

  [[nodiscard]] Eigen::Array3i cellOf(const Vector3& p) const;
  [[nodiscard]] std::size_t flat(int x, int y, int z) const;
};

}  // namespace ecorche::mesh
