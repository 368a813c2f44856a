#pragma once

#include <ecorche/envelope/envelope.h>
#include <ecorche/mesh/tet_mesh.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

namespace ecorche::test {

/// Vertices at which the tets of some label do not look like a ball or half a ball: their link is
/// neither a sphere nor a disc.
inline std::int64_t brokenLinks(const mesh::Tets& T, Eigen::Index vertexCount,
                                const std::vector<TissueId>& label) {
  const mesh::VertexTets around = mesh::vertexTets(T, vertexCount);
  std::int64_t broken = 0;
  for (std::int32_t v = 0; v < vertexCount; ++v) {
    std::map<TissueId, std::vector<std::array<std::int32_t, 3>>> links;
    for (std::int32_t i = around.first[static_cast<std::size_t>(v)];
         i < around.first[static_cast<std::size_t>(v) + 1]; ++i) {
      const std::int32_t t = around.tet[static_cast<std::size_t>(i)];
      std::array<std::int32_t, 3> face{};
      for (int c = 0, n = 0; c < 4; ++c) {
        if (T(t, c) != v) face[static_cast<std::size_t>(n++)] = T(t, c);
      }
      std::ranges::sort(face);
      links[label[static_cast<std::size_t>(t)]].push_back(face);
    }
    for (const auto& [tissue, faces] : links) {
      std::map<std::array<std::int32_t, 2>, std::vector<std::size_t>> edges;
      std::set<std::int32_t> vertices;
      for (std::size_t f = 0; f < faces.size(); ++f) {
        const auto& [a, b, c] = faces[f];
        for (const auto& e : {std::array{a, b}, std::array{b, c}, std::array{a, c}})
          edges[e].push_back(f);
        vertices.insert({a, b, c});
      }
      // Connected across edges?
      std::vector<std::uint8_t> seen(faces.size(), 0);
      std::vector<std::size_t> front{0};
      seen[0] = 1;
      std::size_t reached = 0;
      while (!front.empty()) {
        const std::size_t f = front.back();
        front.pop_back();
        ++reached;
        const auto& [a, b, c] = faces[f];
        for (const auto& e : {std::array{a, b}, std::array{b, c}, std::array{a, c}}) {
          for (const std::size_t g : edges[e]) {
            if (!seen[g]) front.push_back(g);
            seen[g] = 1;
          }
        }
      }
      bool border = false;
      bool crowded = false;
      for (const auto& [e, users] : edges) {
        border |= users.size() == 1;
        crowded |= users.size() > 2;
      }
      const auto euler = static_cast<std::int64_t>(vertices.size()) -
                         static_cast<std::int64_t>(edges.size()) +
                         static_cast<std::int64_t>(faces.size());
      broken += reached != faces.size() || crowded || euler != (border ? 1 : 2);
    }
  }
  return broken;
}

}  // namespace ecorche::test
