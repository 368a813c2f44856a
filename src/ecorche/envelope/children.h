#pragma once

#include <ecorche/envelope/placing.h>
#include <ecorche/envelope/splitting.h>

#include <cstdint>
#include <vector>

namespace ecorche::envelope {

/// Which corners of a parent, and which of its faces, the parts of its children belong to.
class Ancestry {
 public:
  /// @param parents      the domain's tets
  /// @param vertexCount  of the domain; new vertices are numbered from there
  Ancestry(const mesh::Tets& parents, std::int32_t vertexCount,
           const std::vector<Anatomy::Origin>& origin)
      : parents_(parents), vertexCount_(vertexCount), origin_(origin) {}

  /// Corners of the parent (bit c for corner c) that span the simplex which holds the vertex in its
  /// interior.
  [[nodiscard]] unsigned support(std::int32_t parent, std::int32_t vertex) const;

  /// Face of the parent (by opposite corner) that holds these three vertices; -1 if they span its
  /// inside.
  [[nodiscard]] int face(std::int32_t parent, const Face& vertices) const;

 private:
  const mesh::Tets& parents_;
  std::int32_t vertexCount_;
  const std::vector<Anatomy::Origin>& origin_;
};

/// Vertices of a tet's face opposite corner k, ascending.
[[nodiscard]] Face sortedFace(const mesh::Tets& T, Eigen::Index tet, int k);

struct ChildAdjacency {
  mesh::TetNeighbours neighbours;  ///< #children×4
  std::int64_t unmatchedFaces =
      0;  ///< faces that meet nothing though they are not on the boundary; 0 is the promise
};

/// Neighbours in the subdivision from those of the domain. Faces are matched inside each parent and
/// with the parent next door only, so a face that its two sides cut differently shows.
[[nodiscard]] ChildAdjacency linkChildren(const mesh::Tets& T,
                                          const mesh::TetNeighbours& neighbours,
                                          const Diagram& diagram, const Split& split,
                                          const Ancestry& ancestry);

}  // namespace ecorche::envelope
