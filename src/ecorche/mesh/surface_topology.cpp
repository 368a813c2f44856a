#include <ecorche/core/index.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/disjoint_sets.h>
#include <ecorche/mesh/surface_topology.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <unordered_map>

namespace ecorche::mesh {

namespace {

struct EdgeUse {
  std::int32_t a;
  std::int32_t b;
  std::int32_t slot;
  auto operator<=>(const EdgeUse&) const = default;
};

// A slot's other end: the next corner of the same face.
std::int32_t nextCorner(std::int32_t slot) { return slot % 3 == 2 ? slot - 2 : slot + 1; }

}  // namespace

SurfaceEdges surfaceEdges(const Triangles& F) {
  std::vector<EdgeUse> uses;
  uses.reserve(static_cast<std::size_t>(F.rows()) * 3);
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    if (F(f, 0) == F(f, 1) || F(f, 1) == F(f, 2) || F(f, 2) == F(f, 0)) continue;
    for (int k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(F(f, k), F(f, (k + 1) % 3));
      uses.push_back({a, b, static_cast<std::int32_t>(3 * f + k)});
    }
  }
  tbb::parallel_sort(uses.begin(), uses.end());

  SurfaceEdges edges;
  edges.ends.reserve(uses.size() / 2);
  edges.first.reserve(uses.size() / 2 + 1);
  edges.slot.reserve(uses.size());
  for (std::size_t u = 0; u < uses.size(); ++u) {
    if (u == 0 || uses[u].a != uses[u - 1].a || uses[u].b != uses[u - 1].b) {
      edges.ends.push_back({uses[u].a, uses[u].b});
      edges.first.push_back(static_cast<std::int32_t>(u));
    }
    edges.slot.push_back(uses[u].slot);
  }
  edges.first.push_back(static_cast<std::int32_t>(uses.size()));
  return edges;
}

bool isClosed(const Triangles& F) {
  const SurfaceEdges edges = surfaceEdges(F);
  for (std::size_t e = 0; e < edges.count(); ++e) {
    if (edges.faceCount(e) % 2 != 0) return false;
  }
  return edges.count() > 0;
}

bool isManifold(const Triangles& F) {
  const SurfaceEdges edges = surfaceEdges(F);
  for (std::size_t e = 0; e < edges.count(); ++e) {
    if (edges.faceCount(e) > 2) return false;
  }
  return vertexFans(F, edges).nonManifoldVertices.empty();
}

bool isOriented(const Triangles& F) {
  const SurfaceEdges edges = surfaceEdges(F);
  for (std::size_t e = 0; e < edges.count(); ++e) {
    std::int32_t balance = 0;  // faces that run upwards minus those that run downwards
    for (std::int32_t u = edges.first[e]; u < edges.first[e + 1]; ++u) {
      const std::int32_t s = edges.slot[toIndex(u)];
      balance += F(s / 3, s % 3) == edges.ends[e][0] ? 1 : -1;
    }
    if (std::abs(balance) != edges.faceCount(e) % 2) return false;
  }
  return true;
}

FaceComponents components(const Triangles& F) { return components(F, surfaceEdges(F)); }

FaceComponents components(const Triangles& F, const SurfaceEdges& edges) {
  DisjointSets sets(static_cast<std::size_t>(F.rows()));
  for (std::size_t e = 0; e < edges.count(); ++e) {
    const std::int32_t head = edges.slot[toIndex(edges.first[e])] / 3;
    for (std::int32_t u = edges.first[e] + 1; u < edges.first[e + 1]; ++u) {
      sets.unite(head, edges.slot[toIndex(u)] / 3);
    }
  }
  FaceComponents out;
  out.count = sets.label(out.label);
  return out;
}

VertexFans vertexFans(const Triangles& F, const SurfaceEdges& edges) {
  DisjointSets corners(static_cast<std::size_t>(F.rows()) * 3);
  const auto cornerAt = [&](std::int32_t slot, std::int32_t vertex) {
    return F(slot / 3, slot % 3) == vertex ? slot : nextCorner(slot);
  };
  for (std::size_t e = 0; e < edges.count(); ++e) {
    const std::int32_t head = edges.slot[toIndex(edges.first[e])];
    for (std::int32_t u = edges.first[e] + 1; u < edges.first[e + 1]; ++u) {
      for (const std::int32_t v : edges.ends[e])
        corners.unite(cornerAt(head, v), cornerAt(edges.slot[toIndex(u)], v));
    }
  }
  VertexFans out;
  out.count = corners.label(out.fanOfCorner);

  std::vector<std::int32_t> fanOfVertex(F.size() > 0 ? toIndex(F.maxCoeff()) + 1 : 0, -1);
  for (std::size_t c = 0; c < out.fanOfCorner.size(); ++c) {
    const auto f = static_cast<Eigen::Index>(c / 3);
    if (F(f, 0) == F(f, 1) || F(f, 1) == F(f, 2) || F(f, 2) == F(f, 0)) continue;
    const std::int32_t v = F(f, static_cast<Eigen::Index>(c % 3));
    std::int32_t& known = fanOfVertex[toIndex(v)];
    if (known < 0) known = out.fanOfCorner[c];
    if (known != out.fanOfCorner[c]) out.nonManifoldVertices.push_back(v);
  }
  std::ranges::sort(out.nonManifoldVertices);
  out.nonManifoldVertices.erase(
      std::unique(out.nonManifoldVertices.begin(), out.nonManifoldVertices.end()),
      out.nonManifoldVertices.end());
  return out;
}

std::vector<Border> borders(const SurfaceEdges& edges) {
  std::vector<std::int32_t> open;
  for (std::size_t e = 0; e < edges.count(); ++e) {
    if (edges.faceCount(e) == 1) open.push_back(static_cast<std::int32_t>(e));
  }
  DisjointSets sets(open.size());
  std::unordered_map<std::int32_t, std::int32_t> firstAt;  // vertex → an open edge there
  for (std::size_t i = 0; i < open.size(); ++i) {
    for (const std::int32_t v : edges.ends[toIndex(open[i])]) {
      const auto [at, isNew] = firstAt.try_emplace(v, static_cast<std::int32_t>(i));
      if (!isNew) sets.unite(at->second, static_cast<std::int32_t>(i));
    }
  }
  std::vector<std::int32_t> label;
  std::vector<Border> out(toIndex(sets.label(label)));
  for (std::size_t i = 0; i < open.size(); ++i) out[toIndex(label[i])].edges.push_back(open[i]);
  return out;
}

}  // namespace ecorche::mesh
