#include <ecorche/core/index.h>
#include <ecorche/envelope/children.h>
#include <ecorche/envelope/collect.h>

#include <algorithm>
#include <atomic>

namespace ecorche::envelope {
namespace {

using mesh::kTetFace;
using mesh::Tets;

struct ChildFace {
  Face face;
  std::int32_t slot = -1;    // 4·child + corner
  std::int32_t across = -1;  // face of the parent
  auto operator<=>(const ChildFace&) const = default;
};

int cornerNotIn(const Tets& T, Eigen::Index t, const Face& face) {
  for (int c = 0; c < 4; ++c) {
    if (std::ranges::find(face, T(t, c)) == face.end()) return c;
  }
  return -1;
}

/// Links faces of a parent's children among themselves; returns those that are left, ascending.
void linkSiblings(const Split& split, std::int32_t parent, mesh::TetNeighbours& N,
                  std::vector<ChildFace>& left) {
  thread_local std::vector<ChildFace> faces;
  faces.clear();
  for (std::int32_t c = split.firstChild[toIndex(parent)];
       c < split.firstChild[toIndex(parent) + 1]; ++c) {
    for (int k = 0; k < 4; ++k) faces.push_back({sortedFace(split.T, c, k), 4 * c + k, -1});
  }
  std::ranges::sort(faces);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (i + 1 < faces.size() && faces[i].face == faces[i + 1].face) {
      const std::int32_t a = faces[i].slot;
      const std::int32_t b = faces[i + 1].slot;
      N(a / 4, a % 4) = b / 4;
      N(b / 4, b % 4) = a / 4;
      ++i;
    } else {
      left.push_back(faces[i]);
    }
  }
}

}  // namespace

unsigned Ancestry::support(std::int32_t parent, std::int32_t vertex) const {
  const auto bit = [&](std::int32_t v) {
    for (int c = 0; c < 4; ++c) {
      if (parents_(parent, c) == v) return 1U << c;
    }
    return 0U;
  };
  if (vertex < vertexCount_) return bit(vertex);
  unsigned mask = 0;
  for (const std::int32_t corner : origin_[toIndex(vertex - vertexCount_)].corner) {
    if (corner >= 0) mask |= bit(corner);
  }
  return mask;
}

int Ancestry::face(std::int32_t parent, const Face& vertices) const {
  unsigned mask = 0;
  for (const std::int32_t v : vertices) mask |= support(parent, v);
  for (int k = 0; k < 4; ++k) {
    if ((mask | 1U << k) != mask) return k;
  }
  return -1;
}

Face sortedFace(const Tets& T, Eigen::Index tet, int k) {
  Face face{T(tet, kTetFace[k][0]), T(tet, kTetFace[k][1]), T(tet, kTetFace[k][2])};
  std::ranges::sort(face);
  return face;
}

ChildAdjacency linkChildren(const Tets& T, const mesh::TetNeighbours& neighbours, const Diagram& d,
                            const Split& split, const Ancestry& ancestry) {
  ChildAdjacency out;
  auto& N = out.neighbours;
  N.setConstant(split.T.rows(), 4, -1);

  // Inside each mixed parent; what is left lies on the parent's faces
  std::vector<std::int32_t> mixedOf(toIndex(T.rows()), -1);
  parallelFor(static_cast<std::int64_t>(d.mixed.size()), [&](std::int64_t m) {
    mixedOf[toIndex(d.mixed[toIndex(m)])] = static_cast<std::int32_t>(m);
  });
  std::vector<std::int32_t> outerFirst(d.mixed.size(), 0);
  const auto outer = collect<ChildFace>(
      static_cast<std::int64_t>(d.mixed.size()),
      [&](std::int64_t m, auto& all) {
        const std::int32_t t = d.mixed[toIndex(m)];
        const std::size_t before = all.size();
        linkSiblings(split, t, N, all);
        for (std::size_t i = before; i < all.size(); ++i)
          all[i].across = ancestry.face(t, all[i].face);
        outerFirst[toIndex(m)] = static_cast<std::int32_t>(all.size() - before);
      },
      256);
  prefixSum(outerFirst);

  // Across the faces of mixed parents
  std::atomic<std::int64_t> unmatched{0};
  parallelFor(
      static_cast<std::int64_t>(d.mixed.size()),
      [&](std::int64_t m) {
        for (std::int32_t i = outerFirst[toIndex(m)]; i < outerFirst[toIndex(m) + 1]; ++i) {
          const ChildFace& own = outer[toIndex(i)];
          if (own.across < 0) {
            ++unmatched;
            continue;
          }
          const std::int32_t beyond = neighbours(d.mixed[toIndex(m)], own.across);
          if (beyond < 0) continue;
          std::int32_t& link = N(own.slot / 4, own.slot % 4);
          if (const std::int32_t other = mixedOf[toIndex(beyond)]; other >= 0) {
            const auto begin = outer.begin() + outerFirst[toIndex(other)];
            const auto end = outer.begin() + outerFirst[toIndex(other) + 1];
            const auto found =
                std::lower_bound(begin, end, own.face,
                                 [](const ChildFace& f, const Face& key) { return f.face < key; });
            if (found != end && found->face == own.face) {
              link = found->slot / 4;
              continue;
            }
          } else if (const int k = cornerNotIn(T, beyond, own.face); std::ranges::all_of(
                         own.face, [&](auto v) { return (T.row(beyond).array() == v).any(); })) {
            link = split.firstChild[toIndex(beyond)];
            N(link, k) = own.slot / 4;
            continue;
          }
          ++unmatched;
        }
      },
      256);

  // Parents that stayed whole, among themselves
  parallelFor(T.rows(), [&](std::int64_t t) {
    if (mixedOf[toIndex(t)] >= 0) return;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t beyond = neighbours(t, k);
      if (beyond >= 0 && mixedOf[toIndex(beyond)] < 0)
        N(split.firstChild[toIndex(t)], k) = split.firstChild[toIndex(beyond)];
    }
  });
  out.unmatchedFaces = unmatched;
  return out;
}

}  // namespace ecorche::envelope
