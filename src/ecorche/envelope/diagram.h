#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/envelope/candidates.h>
#include <ecorche/mesh/tet_mesh.h>
#include <ecorche/tissue/tissue_fields.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace ecorche::envelope {

using Edge = std::array<std::int32_t, 2>;    ///< vertices of the domain, ascending
using Face = std::array<std::int32_t, 3>;    ///< vertices of the domain, ascending
using Triple = std::array<std::int32_t, 3>;  ///< columns of fields that tie, ascending
using Quad = std::array<std::int32_t, 4>;    ///< columns of fields that tie, ascending

/// Which field is largest where: the maximisation diagram as names, without places.
///
/// New vertices are named by the smallest simplex that holds them and by the fields that tie there.
/// A line, a plane's trace and a tet hold each combination at most once, so the name tells vertices
/// apart, and both sides of a shared simplex use the same list. Everything here is decided exactly
/// (TiedPoint).
///
/// New vertices are numbered from #V: edge points by edge and along it from the lower vertex, then
/// face points by face and columns, then tet points by tet and columns.
struct Diagram {
  std::vector<std::int32_t> owner;  ///< #V column of the field on top

  // Edges whose ends have different owners, ascending
  std::vector<Edge> edges;
  std::vector<std::int32_t>
      edgeFirst;  ///< #edges + 1: crossings of edge e are edgeFirst[e] … edgeFirst[e+1]-1
  std::vector<std::int32_t>
      labelAfter;  ///< per crossing: the owner beyond it, going from the lower vertex

  // Faces with three or more owners on their edges, ascending
  std::vector<Face> faces;
  std::vector<std::int32_t> faceFirst;  ///< #faces + 1
  std::vector<Triple> facePoints;       ///< ascending within a face

  // Tets whose corners are not all of one owner, ascending
  std::vector<std::int32_t> mixed;
  std::vector<std::array<std::int32_t, 6>>
      mixedEdges;  ///< per mixed tet and kTetEdge: index into edges, -1 unmixed
  std::vector<std::int32_t>
      complexOf;  ///< per mixed tet: index into the lists below, -1 with exactly two owners

  // Mixed tets with three or more owners
  std::vector<std::int32_t> complex;  ///< index into `mixed`, ascending
  std::vector<std::array<std::int32_t, 4>>
      complexFaces;                    ///< opposite corner k: index into faces, -1
  std::vector<std::int32_t> tetFirst;  ///< #complex + 1
  std::vector<Quad> tetPoints;         ///< ascending within a tet

  /// Struck tissues that show on the boundary of their tet all the same, because a neighbour still
  /// admits them.
  std::vector<TissueInTet> conflicts;

  [[nodiscard]] std::int32_t vertexCount() const { return static_cast<std::int32_t>(owner.size()); }
  [[nodiscard]] std::int32_t edgePointId(std::int32_t crossing) const {
    return vertexCount() + crossing;
  }
  [[nodiscard]] std::int32_t facePointId(std::int32_t point) const {
    return edgePointId(static_cast<std::int32_t>(labelAfter.size())) + point;
  }
  [[nodiscard]] std::int32_t tetPointId(std::int32_t point) const {
    return facePointId(static_cast<std::int32_t>(facePoints.size())) + point;
  }
  [[nodiscard]] std::int32_t newVertexCount() const {
    return tetPointId(static_cast<std::int32_t>(tetPoints.size())) - vertexCount();
  }
  /// Owner just before a crossing of edge e.
  [[nodiscard]] std::int32_t labelBefore(std::int32_t e, std::int32_t crossing) const {
    const auto i = static_cast<std::size_t>(e);
    return crossing == edgeFirst[i] ? owner[static_cast<std::size_t>(edges[i][0])]
                                    : labelAfter[static_cast<std::size_t>(crossing) - 1];
  }
};

/// @param T       #T×4, no vertex twice in a tet
/// @param fields  #V×#fields, finite
/// @return the same diagram for any number of threads and any order of corners within tets
/// @errors NonFiniteField (names tissue id and vertex), Cancelled
[[nodiscard]] Result<Diagram> computeDiagram(const mesh::Tets& T, const tissue::FieldMatrix& fields,
                                             const Candidates& candidates, RunContext& run);

/// Owners on the face opposite corner k of a mixed tet, ascending columns.
/// @param m  index into diagram.mixed
[[nodiscard]] std::vector<std::int32_t> ownersOnFace(const mesh::Tets& T, const Diagram& diagram,
                                                     std::int32_t m, int k);

/// Owners inside every tet of `complex`, ascending columns.
[[nodiscard]] std::vector<std::vector<std::int32_t>> ownersOfComplexTets(const Diagram& diagram);

}  // namespace ecorche::envelope
