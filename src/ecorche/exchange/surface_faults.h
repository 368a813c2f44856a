#pragma once

#include <ecorche/mesh/types.h>

#include <cstdint>

namespace ecorche::exchange {

/// What keeps triangles from being a closed, oriented manifold. Vertices give the first place at
/// fault, -1 where none is.
struct SurfaceFaults {
  std::int64_t openEdges = 0;            ///< with one face
  std::int64_t nonManifoldEdges = 0;     ///< with three faces or more
  std::int64_t misorientedEdges = 0;     ///< two faces that run along it the same way
  std::int64_t nonManifoldVertices = 0;  ///< whose faces form more than one fan
  std::int32_t openAt = -1;
  std::int32_t nonManifoldEdgeAt = -1;
  std::int32_t nonManifoldVertexAt = -1;
};

[[nodiscard]] SurfaceFaults surfaceFaults(const mesh::Triangles& F);

}  // namespace ecorche::exchange
