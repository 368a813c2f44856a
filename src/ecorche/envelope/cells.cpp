#include <ecorche/core/contract.h>
#include <ecorche/core/index.h>
#include <ecorche/envelope/splitting.h>

#include <algorithm>
#include <array>

// The cells of a tet are simple polytopes, and names alone tell how they hang together. Every point
// lies on exactly four *walls*: the owners that tie there, and the tet's faces that hold it. In the
// cell of an owner L each other wall of one of L's points is a facet, two points are joined by an
// edge if they share two walls besides L, and a point's three facets meet in its three edges.

namespace ecorche::envelope {
namespace {

using mesh::kTetEdge;
using mesh::kTetFace;
using mesh::Tets;

/// 0 … 3: the tet's face opposite that corner; 4 + column: an owner.
using Wall = std::int32_t;
constexpr Wall wallOf(std::int32_t column) { return 4 + column; }

struct Point {
  std::int32_t id = -1;
  std::array<Wall, 4> wall{-1, -1, -1, -1};
  [[nodiscard]] bool on(Wall w) const {
    return wall[0] == w || wall[1] == w || wall[2] == w || wall[3] == w;
  }
};

/// A polygon between the cell of `inner` and what lies behind `outer`.
struct Facet {
  Wall inner = -1;
  Wall outer = -1;  ///< another owner (then inner < outer) or a face of the tet
  std::vector<std::int32_t>
      loop;  ///< points in order; once oriented, counter-clockwise seen from outside `inner`
  bool oriented = false;
};

class CellComplex {
 public:
  CellComplex(const Tets& T, const Diagram& d, std::int32_t x)
      : tet_(d.mixed[toIndex(d.complex[toIndex(x)])]) {
    addPoints(T, d, x);
    addFacets();
    orient();
  }

  void pull(std::vector<SubTet>& out) const {
    for (const Wall owner : owners_) pullCell(owner, out);
  }

 private:
  void addPoints(const Tets& T, const Diagram& d, std::int32_t x);
  void addFacets();
  void orient();
  void orientCell(Wall owner);
  void pullCell(Wall owner, std::vector<SubTet>& out) const;
  std::vector<std::int32_t> loopOf(Wall inner, Wall outer) const;
  /// Whether the facet's loop runs from p to q, seen from outside the cell of that owner.
  static bool runs(const Facet& facet, Wall owner, std::int32_t p, std::int32_t q);

  std::int32_t tet_;
  std::vector<Point> points_;
  std::vector<Wall> owners_;  ///< ascending
  std::vector<Facet> facets_;
};

void CellComplex::addPoints(const Tets& T, const Diagram& d, std::int32_t x) {
  const std::int32_t m = d.complex[toIndex(x)];
  for (int c = 0; c < 4; ++c) {
    Point p{T(tet_, c), {}};
    for (int f = 0, n = 0; f < 4; ++f) {
      if (f != c) p.wall[toIndex(n++)] = f;
    }
    p.wall[3] = wallOf(d.owner[toIndex(p.id)]);
    points_.push_back(p);
  }
  for (int e = 0; e < 6; ++e) {
    const std::int32_t edge = d.mixedEdges[toIndex(m)][toIndex(e)];
    if (edge < 0) continue;
    for (std::int32_t c = d.edgeFirst[toIndex(edge)]; c < d.edgeFirst[toIndex(edge) + 1]; ++c) {
      Point p{d.edgePointId(c), {}};
      for (int f = 0, n = 0; f < 4; ++f) {
        if (f != kTetEdge[e][0] && f != kTetEdge[e][1]) p.wall[toIndex(n++)] = f;
      }
      p.wall[2] = wallOf(d.labelBefore(edge, c));
      p.wall[3] = wallOf(d.labelAfter[toIndex(c)]);
      points_.push_back(p);
    }
  }
  for (int f = 0; f < 4; ++f) {
    const std::int32_t face = d.complexFaces[toIndex(x)][toIndex(f)];
    if (face < 0) continue;
    for (std::int32_t i = d.faceFirst[toIndex(face)]; i < d.faceFirst[toIndex(face) + 1]; ++i) {
      const Triple& tied = d.facePoints[toIndex(i)];
      points_.push_back({d.facePointId(i), {f, wallOf(tied[0]), wallOf(tied[1]), wallOf(tied[2])}});
    }
  }
  for (std::int32_t i = d.tetFirst[toIndex(x)]; i < d.tetFirst[toIndex(x) + 1]; ++i) {
    const Quad& tied = d.tetPoints[toIndex(i)];
    points_.push_back(
        {d.tetPointId(i), {wallOf(tied[0]), wallOf(tied[1]), wallOf(tied[2]), wallOf(tied[3])}});
  }
}

void CellComplex::addFacets() {
  // Pairs (inner, outer) that some point lies on
  std::vector<std::array<Wall, 2>> pairs;
  for (const Point& p : points_) {
    for (const Wall inner : p.wall) {
      if (inner < 4) continue;
      owners_.push_back(inner);
      for (const Wall outer : p.wall) {
        if (outer < 4 || outer > inner) pairs.push_back({inner, outer});
      }
    }
  }
  const auto sortUnique = [](auto& items) {
    std::ranges::sort(items);
    items.erase(std::unique(items.begin(), items.end()), items.end());
  };
  sortUnique(owners_);
  sortUnique(pairs);
  for (const auto& [inner, outer] : pairs) facets_.push_back({inner, outer, loopOf(inner, outer)});
}

std::vector<std::int32_t> CellComplex::loopOf(Wall inner, Wall outer) const {
  std::vector<std::int32_t> members;
  for (std::size_t i = 0; i < points_.size(); ++i) {
    if (points_[i].on(inner) && points_[i].on(outer))
      members.push_back(static_cast<std::int32_t>(i));
  }
  // From each point along one of its two remaining walls to the other point on it, leaving by the
  // wall not yet used
  std::vector<std::int32_t> loop{members.front()};
  Wall along = -1;
  while (true) {
    const Point& here = points_[toIndex(loop.back())];
    Wall next = -1;
    for (const Wall w : here.wall) {
      if (w != inner && w != outer && w != along) next = w;
    }
    const auto there = std::ranges::find_if(
        members, [&](std::int32_t i) { return i != loop.back() && points_[toIndex(i)].on(next); });
    EC_REQUIRE(there != members.end());
    if (*there == loop.front()) break;
    loop.push_back(*there);
    EC_REQUIRE(loop.size() <= members.size());
    along = next;
  }
  EC_REQUIRE(loop.size() == members.size() && loop.size() >= 3);
  return loop;
}

bool CellComplex::runs(const Facet& facet, Wall owner, std::int32_t p, std::int32_t q) {
  const std::int32_t from = facet.inner == owner ? p : q;
  const std::int32_t to = facet.inner == owner ? q : p;
  for (std::size_t i = 0; i < facet.loop.size(); ++i) {
    if (facet.loop[i] == from) return facet.loop[(i + 1) % facet.loop.size()] == to;
  }
  return false;
}

/// Orients the facets of a cell of which one is oriented: neighbours run along their common edge in
/// opposite ways.
void CellComplex::orientCell(Wall owner) {
  std::vector<Facet*> all;
  for (Facet& f : facets_) {
    if (f.inner == owner || f.outer == owner) all.push_back(&f);
  }
  std::vector<Facet*> front;
  for (Facet* f : all) {
    if (f->oriented) front.push_back(f);
  }
  EC_REQUIRE(!front.empty());
  while (!front.empty()) {
    const Facet* known = front.back();
    front.pop_back();
    for (Facet* f : all) {
      if (f->oriented) continue;
      const Wall beyond = f->inner == owner ? f->outer : f->inner;
      for (std::size_t i = 0; i < known->loop.size(); ++i) {
        const std::int32_t p = known->loop[i];
        const std::int32_t q = known->loop[(i + 1) % known->loop.size()];
        if (!points_[toIndex(p)].on(beyond) || !points_[toIndex(q)].on(beyond)) continue;
        if (runs(*known, owner, p, q) == runs(*f, owner, p, q)) std::ranges::reverse(f->loop);
        f->oriented = true;
        front.push_back(f);
        break;
      }
    }
  }
}

void CellComplex::orient() {
  // A start: corner 0 on face 0 1 2 of the tet, which seen from outside runs 0 2 1
  const Wall start = points_[0].wall[3];
  constexpr Wall kBottom = 3;
  const auto seed = std::ranges::find_if(
      facets_, [&](const Facet& f) { return f.inner == start && f.outer == kBottom; });
  const auto place = std::ranges::find(seed->loop, 0) - seed->loop.begin();
  const Point& next = points_[toIndex(seed->loop[toIndex(place + 1) % seed->loop.size()])];
  // What follows corner 0 must lie on edge 0 2, which is on faces 1 and 3
  if (!next.on(1)) std::ranges::reverse(seed->loop);
  seed->oriented = true;

  // From cell to cell
  std::vector<Wall> front{start};
  std::vector<Wall> done;
  while (!front.empty()) {
    const Wall owner = front.back();
    front.pop_back();
    if (std::ranges::find(done, owner) != done.end()) continue;
    done.push_back(owner);
    orientCell(owner);
    for (const Facet& f : facets_) {
      if (f.inner == owner && f.outer >= 4) front.push_back(f.outer);
      if (f.outer == owner) front.push_back(f.inner);
    }
  }
  EC_REQUIRE_EQ(done.size(), owners_.size());
}

void CellComplex::pullCell(Wall owner, std::vector<SubTet>& out) const {
  std::int32_t apex = -1;
  for (const Point& p : points_) {
    if (p.on(owner) && (apex < 0 || p.id < apex)) apex = p.id;
  }
  std::vector<std::int32_t> loop;
  for (const Facet& f : facets_) {
    if (f.inner != owner && f.outer != owner) continue;
    loop.clear();
    for (const std::int32_t i : f.loop) loop.push_back(points_[toIndex(i)].id);
    if (f.outer == owner) std::ranges::reverse(loop);
    std::ranges::rotate(loop, std::ranges::min_element(loop));
    if (std::ranges::find(loop, apex) != loop.end()) continue;
    for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
      out.push_back({{apex, loop[0], loop[i], loop[i + 1]}, owner - 4});
    }
  }
}

}  // namespace

void splitCells(const Tets& T, const Diagram& d, std::int32_t x, std::vector<SubTet>& out) {
  CellComplex(T, d, x).pull(out);
}

}  // namespace ecorche::envelope
