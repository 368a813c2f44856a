#include <ecorche/exchange/surface_faults.h>
#include <ecorche/mesh/surface_topology.h>

namespace ecorche::exchange {

SurfaceFaults surfaceFaults(const mesh::Triangles& F) {
  const mesh::SurfaceEdges edges = mesh::surfaceEdges(F);
  SurfaceFaults out;
  for (std::size_t e = 0; e < edges.count(); ++e) {
    const std::int32_t faces = edges.faceCount(e);
    const auto startsLow = [&](std::int32_t slot) {
      return F(slot / 3, slot % 3) == edges.ends[e][0];
    };
    const auto first = static_cast<std::size_t>(edges.first[e]);
    if (faces == 1) {
      if (out.openEdges++ == 0) out.openAt = edges.ends[e][0];
    } else if (faces > 2) {
      if (out.nonManifoldEdges++ == 0) out.nonManifoldEdgeAt = edges.ends[e][0];
    } else {
      out.misorientedEdges += startsLow(edges.slot[first]) == startsLow(edges.slot[first + 1]);
    }
  }
  const auto vertices = mesh::vertexFans(F, edges).nonManifoldVertices;
  out.nonManifoldVertices = std::ssize(vertices);
  if (!vertices.empty()) out.nonManifoldVertexAt = vertices.front();
  return out;
}

}  // namespace ecorche::exchange
