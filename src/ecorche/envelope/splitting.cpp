#include <ecorche/core/contract.h>
#include <ecorche/core/index.h>
#include <ecorche/envelope/collect.h>
#include <ecorche/envelope/splitting.h>

#include <algorithm>

namespace ecorche::envelope {
namespace {

using mesh::kTetEdge;
using mesh::kTetFace;
using mesh::Tets;

/// A prism with triangles b and t and edges b_i t_i; t seen from outside runs counter-clockwise, b
/// clockwise.
void pullPrism(std::array<std::int32_t, 3> b, std::array<std::int32_t, 3> t, std::int32_t column,
               std::vector<SubTet>& out) {
  // Turn it until its lowest vertex is t0
  if (std::ranges::min(b) < std::ranges::min(t)) {
    std::swap(b, t);
    std::swap(b[1], b[2]);
    std::swap(t[1], t[2]);
  }
  const auto shift = std::ranges::min_element(t) - t.begin();
  std::ranges::rotate(t, t.begin() + shift);
  std::ranges::rotate(b, b.begin() + shift);

  // Faces without t0: the triangle b, and the quad b1 b2 t2 t1, cut from its own lowest vertex
  out.push_back({{t[0], b[0], b[2], b[1]}, column});
  std::array<std::int32_t, 4> quad{b[1], b[2], t[2], t[1]};
  std::ranges::rotate(quad, std::ranges::min_element(quad));
  out.push_back({{t[0], quad[0], quad[1], quad[2]}, column});
  out.push_back({{t[0], quad[0], quad[2], quad[3]}, column});
}

/// Corner orders (p; q, r, s) with the orientation of (0; 1, 2, 3), by p.
constexpr int kFrom[4][4] = {{0, 1, 2, 3}, {1, 0, 3, 2}, {2, 0, 1, 3}, {3, 0, 2, 1}};
/// Orders (p0, p1, q0, q1) with the orientation of (0, 1, 2, 3), by the partner of corner 0 less
/// one.
constexpr int kPairs[3][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}};

constexpr int kEdgeBetween[4][4] = {{-1, 0, 1, 2}, {0, -1, 3, 4}, {1, 3, -1, 5}, {2, 4, 5, -1}};

}  // namespace

void splitTwoOwners(const Tets& T, const Diagram& d, std::int32_t m, std::vector<SubTet>& out) {
  const std::int32_t t = d.mixed[toIndex(m)];
  const auto corner = [&](int c) { return T(t, c); };
  const auto owner = [&](int c) { return d.owner[toIndex(T(t, c))]; };
  const auto point = [&](int a, int b) {
    return d.edgePointId(
        d.edgeFirst[toIndex(d.mixedEdges[toIndex(m)][toIndex(kEdgeBetween[a][b])])]);
  };
  int same[4];  // corners with this corner's owner
  for (int c = 0; c < 4; ++c) {
    same[c] = 0;
    for (int o = 0; o < 4; ++o) same[c] += owner(o) == owner(c);
  }
  for (int c = 0; c < 4; ++c) {
    if (same[c] != 1) continue;
    // One against three: a tet at the lone corner and a prism
    const auto& [p, q, r, s] = kFrom[c];
    const std::array cut{point(p, q), point(p, r), point(p, s)};
    out.push_back({{corner(p), cut[0], cut[1], cut[2]}, owner(p)});
    pullPrism(cut, {corner(q), corner(r), corner(s)}, owner(q), out);
    return;
  }
  // Two against two: a prism each
  int partner = 1;
  while (owner(partner) != owner(0)) ++partner;
  const auto& [p0, p1, q0, q1] = kPairs[partner - 1];
  pullPrism({corner(p0), point(p0, q0), point(p0, q1)}, {corner(p1), point(p1, q0), point(p1, q1)},
            owner(p0), out);
  pullPrism({corner(q0), point(p0, q0), point(p1, q0)}, {corner(q1), point(p0, q1), point(p1, q1)},
            owner(q0), out);
}

Split splitTets(const Tets& T, const Diagram& d) {
  // The few tets with three owners and more, in any shape
  std::vector<std::int32_t> complexFirst(d.complex.size(), 0);
  const auto complexChildren = collect<SubTet>(
      static_cast<std::int64_t>(d.complex.size()),
      [&](std::int64_t x, auto& out) {
        const auto before = out.size();
        splitCells(T, d, static_cast<std::int32_t>(x), out);
        complexFirst[toIndex(x)] = static_cast<std::int32_t>(out.size() - before);
      },
      64);
  prefixSum(complexFirst);

  // Count
  Split split;
  split.firstChild.assign(toIndex(T.rows()), 1);
  parallelFor(static_cast<std::int64_t>(d.mixed.size()), [&](std::int64_t m) {
    const std::int32_t t = d.mixed[toIndex(m)];
    std::int32_t& count = split.firstChild[toIndex(t)];
    if (const std::int32_t x = d.complexOf[toIndex(m)]; x >= 0) {
      count = complexFirst[toIndex(x) + 1] - complexFirst[toIndex(x)];
    } else {
      const int crossed = static_cast<int>(
          std::ranges::count_if(d.mixedEdges[toIndex(m)], [](auto e) { return e >= 0; }));
      count = crossed == 3 ? 4 : 6;
    }
  });
  prefixSum(split.firstChild);

  // Fill
  const std::int32_t total = split.firstChild.back();
  split.T.resize(total, 4);
  split.column.resize(toIndex(total));
  split.parent.resize(toIndex(total));
  parallelFor(T.rows(), [&](std::int64_t t) {
    const auto c = toIndex(split.firstChild[toIndex(t)]);
    if (split.firstChild[toIndex(t) + 1] - split.firstChild[toIndex(t)] > 1) return;
    split.T.row(static_cast<Eigen::Index>(c)) = T.row(t);
    split.column[c] = d.owner[toIndex(T(t, 0))];
    split.parent[c] = static_cast<std::int32_t>(t);
  });
  parallelFor(
      static_cast<std::int64_t>(d.mixed.size()),
      [&](std::int64_t m) {
        const std::int32_t t = d.mixed[toIndex(m)];
        thread_local std::vector<SubTet> children;
        children.clear();
        if (const std::int32_t x = d.complexOf[toIndex(m)]; x >= 0) {
          children.assign(complexChildren.begin() + complexFirst[toIndex(x)],
                          complexChildren.begin() + complexFirst[toIndex(x) + 1]);
        } else {
          splitTwoOwners(T, d, static_cast<std::int32_t>(m), children);
        }
        EC_ASSERT(static_cast<std::int32_t>(children.size()) ==
                      split.firstChild[toIndex(t) + 1] - split.firstChild[toIndex(t)],
                  "tet {} has {} children", t, children.size());
        std::int32_t c = split.firstChild[toIndex(t)];
        for (const SubTet& child : children) {
          for (int k = 0; k < 4; ++k) split.T(c, k) = child.vertex[toIndex(k)];
          split.column[toIndex(c)] = child.column;
          split.parent[toIndex(c)] = t;
          ++c;
        }
      },
      256);
  return split;
}

}  // namespace ecorche::envelope
