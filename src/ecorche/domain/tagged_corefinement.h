#pragma once

#include <ecorche/domain/tagged_surface.h>
#include <ecorche/mesh/cgal_surface.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace ecorche::domain {

/// For translation units that speak CGAL. The tag of a face is its property "f:tag"; set operations
/// hand it on to the pieces that they make of the face.
using TaggedMesh = mesh::CgalSurface;
using TagMap = TaggedMesh::Property_map<TaggedMesh::Face_index, std::int32_t>;

/// The tags of the mesh, all 0 where it had none.
[[nodiscard]] TagMap tagsOf(TaggedMesh& mesh);

/// Nothing for what is not an oriented manifold.
[[nodiscard]] std::optional<TaggedMesh> toCgal(const TaggedSurface& surface);
[[nodiscard]] TaggedSurface fromCgal(TaggedMesh& mesh);

enum class Operation { Union, Difference, Intersection };

/// a := a op b with tags. False, and a untouched, where the result would not be a manifold or the
/// library gives up.
bool combine(TaggedMesh& a, const TaggedMesh& b, Operation operation);

/// The half space of a cut plane as a box so large that only its first face matters to what lies
/// within `around`, wherever on the plane its point is.
/// @param plane  its normal of length 1
[[nodiscard]] TaggedMesh halfSpace(const CutPlane& plane, std::int32_t tag,
                                   const mesh::Box& around);

/// Pieces of a mesh that hang together by edges.
struct MeshPieces {
  std::vector<std::int32_t> label;                         ///< by face index, from 0
  std::vector<std::vector<TaggedMesh::Face_index>> faces;  ///< of each piece
};
[[nodiscard]] MeshPieces piecesOf(const TaggedMesh& mesh);
/// A vertex of every piece.
[[nodiscard]] std::vector<mesh::CgalKernel::Point_3> pointsOfPieces(const TaggedMesh& mesh);
/// The mesh without pieces for which `kept` is 0.
[[nodiscard]] TaggedMesh keepPieces(TaggedMesh mesh, const MeshPieces& pieces,
                                    const std::vector<char>& kept);

/// Some point of a mesh that has one.
[[nodiscard]] mesh::Vector3 anyPoint(const TaggedMesh& mesh);

}  // namespace ecorche::domain
