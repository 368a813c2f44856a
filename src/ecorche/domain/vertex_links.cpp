#include <ecorche/core/index.h>
#include <ecorche/core/parallel.h>
#include <ecorche/domain/vertex_links.h>

#include <algorithm>
#include <array>
#include <atomic>

namespace ecorche::domain {

namespace {

/// Groups of tets around v that share faces with v in them, as a group number per entry of
/// `around`.
int fansOf(const mesh::Tets& T, const mesh::TetNeighbours& neighbours, std::int32_t v,
           const std::int32_t* around, std::size_t count, std::vector<int>& fan) {
  fan.assign(count, -1);
  int fans = 0;
  std::vector<std::size_t> open;
  for (std::size_t seed = 0; seed < count; ++seed) {
    if (fan[seed] >= 0) continue;
    fan[seed] = fans;
    open.push_back(seed);
    while (!open.empty()) {
      const std::int32_t t = around[open.back()];
      open.pop_back();
      for (int k = 0; k < 4; ++k) {
        if (T(t, k) == v || neighbours(t, k) < 0) continue;
        const auto it = std::lower_bound(around, around + count, neighbours(t, k));
        const auto slot = static_cast<std::size_t>(it - around);
        if (slot < count && *it == neighbours(t, k) && fan[slot] < 0) {
          fan[slot] = fans;
          open.push_back(slot);
        }
      }
    }
    ++fans;
  }
  return fans;
}

/// The link's Euler characteristic and boundary: a sphere has 2 and no border, a disc 1 and one
/// closed border.
bool linkIsSphereOrDisc(const mesh::Tets& T, const mesh::TetNeighbours& neighbours, std::int32_t v,
                        const std::int32_t* around, std::size_t count) {
  std::vector<int> fan;
  if (fansOf(T, neighbours, v, around, count, fan) != 1) return false;
  std::vector<std::int32_t> vertices;
  std::vector<std::array<std::int32_t, 2>> edges;
  std::vector<std::int32_t> border;  // ends of border edges
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t t = around[i];
    std::array<std::int32_t, 3> tri{};
    std::size_t n = 0;
    for (int k = 0; k < 4; ++k) {
      if (T(t, k) != v) tri[n++] = T(t, k);
    }
    std::ranges::sort(tri);
    vertices.insert(vertices.end(), tri.begin(), tri.end());
    edges.push_back({tri[0], tri[1]});
    edges.push_back({tri[0], tri[2]});
    edges.push_back({tri[1], tri[2]});
    for (int k = 0; k < 4; ++k) {
      if (T(t, k) == v || neighbours(t, k) >= 0) continue;
      for (int c = 0; c < 4; ++c) {
        if (c != k && T(t, c) != v) border.push_back(T(t, c));
      }
    }
  }
  const auto countUnique = [](auto& items) {
    std::ranges::sort(items);
    return std::ranges::unique(items).begin() - items.begin();
  };
  const auto euler =
      countUnique(vertices) - countUnique(edges) + static_cast<std::ptrdiff_t>(count);
  if (border.empty()) return euler == 2;
  // Every border vertex has two border edges; a connected surface with Euler number 1 has one
  // border
  std::ranges::sort(border);
  for (std::size_t i = 0; i < border.size(); i += 2) {
    if (i + 1 >= border.size() || border[i] != border[i + 1] ||
        (i + 2 < border.size() && border[i + 2] == border[i])) {
      return false;
    }
  }
  return euler == 1;
}

}  // namespace

std::optional<Eigen::Index> firstSingularVertex(const mesh::TetMesh& mesh,
                                                const mesh::TetNeighbours& neighbours) {
  const auto incident = mesh::vertexTets(mesh.T, mesh.V.rows());
  std::atomic<std::int64_t> first{mesh.V.rows()};
  parallelFor(mesh.V.rows(), [&](std::int64_t v) {
    const auto begin = toIndex(incident.first[toIndex(v)]);
    const auto count = toIndex(incident.first[toIndex(v + 1)]) - begin;
    if (count == 0 || linkIsSphereOrDisc(mesh.T, neighbours, static_cast<std::int32_t>(v),
                                         incident.tet.data() + begin, count)) {
      return;
    }
    std::int64_t seen = first.load();
    while (v < seen && !first.compare_exchange_weak(seen, v)) {
    }
  });
  if (first.load() == mesh.V.rows()) return std::nullopt;
  return first.load();
}

}  // namespace ecorche::domain
