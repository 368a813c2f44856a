#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace ecorche::mesh {

/// Every undirected edge with the faces that use it, edges ascending by their ends. Faces that name
/// a vertex twice have no edges here.
struct SurfaceEdges {
  std::vector<std::array<std::int32_t, 2>> ends;  ///< #E, smaller vertex first
  std::vector<std::int32_t> first;                ///< #E+1, into slot
  std::vector<std::int32_t> slot;  ///< 3·face + corner; the edge goes from this corner to the next

  [[nodiscard]] std::size_t count() const { return ends.size(); }
  [[nodiscard]] std::int32_t faceCount(std::size_t e) const { return first[e + 1] - first[e]; }
};
[[nodiscard]] SurfaceEdges surfaceEdges(const Triangles& F);

/// Every edge has an even number of faces: the surface has no border and encloses something.
[[nodiscard]] bool isClosed(const Triangles& F);
/// No edge has more than two faces, and the faces around every vertex form one fan. Borders are
/// allowed.
[[nodiscard]] bool isManifold(const Triangles& F);
/// Faces that share an edge run through it in opposite directions, everywhere.
[[nodiscard]] bool isOriented(const Triangles& F);

/// Pieces that hang together by edges.
struct FaceComponents {
  std::vector<std::int32_t> label;  ///< #F, from 0 in order of first face
  std::int32_t count = 0;
};
[[nodiscard]] FaceComponents components(const Triangles& F);
[[nodiscard]] FaceComponents components(const Triangles& F, const SurfaceEdges& edges);

/// The fans of faces around each vertex: faces of a fan hang together by edges at that vertex. A
/// manifold has one fan at every vertex.
struct VertexFans {
  std::vector<std::int32_t> fanOfCorner;  ///< #F·3, from 0
  std::int32_t count = 0;
  std::vector<std::int32_t> nonManifoldVertices;  ///< vertices with two fans or more, ascending
};
[[nodiscard]] VertexFans vertexFans(const Triangles& F, const SurfaceEdges& edges);

/// Edges with one face, gathered into connected borders.
struct Border {
  std::vector<std::int32_t> edges;  ///< into SurfaceEdges
};
[[nodiscard]] std::vector<Border> borders(const SurfaceEdges& edges);

}  // namespace ecorche::mesh
