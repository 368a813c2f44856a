#include <ecorche/core/contract.h>
#include <ecorche/envelope/simplex_diagram.h>
#include <ecorche/envelope/tied_point.h>

#include <algorithm>
#include <optional>

// Everything here speaks of the perturbed fields. Two of them are equal on a line of a face, three
// on a line of a tet: a chord, whose ends lie on the simplex's boundary. Along a chord every other
// field is linear against the tied ones, so the part of the chord that is on top is an interval,
// cut by fields that are above at one end (at both: nothing is left). Ends of such intervals are
// the points we look for.

namespace ecorche::envelope {
namespace {

using tissue::FieldMatrix;
using Columns = std::vector<std::int32_t>;

bool contains(Candidates::Columns sorted, std::int32_t column) {
  return std::ranges::binary_search(sorted, column);
}

bool beatsAt(const FieldMatrix& fields, std::int32_t vertex, std::int32_t i, std::int32_t j) {
  return beats(fields(vertex, i), i, fields(vertex, j), j);
}

/// Edges of a face (two of its vertices each) on which i and j cross: none or two.
struct PairChord {
  std::array<Edge, 2> end;
};
std::optional<PairChord> pairChord(const FieldMatrix& fields, const Face& face, std::int32_t i,
                                   std::int32_t j) {
  PairChord chord;
  int ends = 0;
  for (int c = 0; c < 3; ++c) {
    const Edge edge{face[std::min(c, (c + 1) % 3)], face[std::max(c, (c + 1) % 3)]};
    if (beatsAt(fields, edge[0], i, j) == beatsAt(fields, edge[1], i, j)) continue;
    chord.end[ends++] = edge;
  }
  if (ends == 0) return std::nullopt;
  return chord;
}

/// Faces of a tet in which i, j and k tie, whatever the others do: none or two.
struct TripleChord {
  std::array<Face, 2> end;
};
std::optional<TripleChord> tripleChord(const FieldMatrix& fields,
                                       const std::array<std::int32_t, 4>& corners,
                                       const Triple& t) {
  TripleChord chord;
  int ends = 0;
  for (int omit = 0; omit < 4; ++omit) {
    Face face;
    for (int c = 0, n = 0; c < 4; ++c) {
      if (c != omit) face[n++] = corners[c];
    }
    const auto pair = pairChord(fields, face, t[0], t[1]);
    if (!pair) continue;
    // k is above at one end of the chord of i and j, and below at the other: it passes them in
    // between
    const Edge tied{t[0], t[1]};
    const bool above0 = TiedPoint<2>(fields, pair->end[0], tied).isBelow(t[2]);
    const bool above1 = TiedPoint<2>(fields, pair->end[1], tied).isBelow(t[2]);
    if (above0 == above1) continue;
    EC_ASSERT(ends < 2, "a line leaves a tet through three faces");
    chord.end[ends++] = face;
  }
  if (ends == 0) return std::nullopt;
  return chord;
}

/// What cuts a chord from either end: the last field to let go behind end 0, the first to take over
/// before end 1; -1 where the end itself is on top. Nothing: all of the chord lies below.
struct Interval {
  std::array<std::int32_t, 2> cutBy{-1, -1};
};

/// @param End    the tied point at an end of the chord
/// @param Inner  the tied point of the chord's fields and one more: inner(k)
template <class End, class Inner>
std::optional<Interval> partOnTop(const Columns& seen, const End& end0, const End& end1,
                                  const Inner& inner, const auto& isTied) {
  Interval interval;
  for (const std::int32_t k : seen) {
    if (isTied(k)) continue;
    const bool above0 = end0.isBelow(k);
    const bool above1 = end1.isBelow(k);
    if (above0 && above1) return std::nullopt;
    if (!above0 && !above1) continue;
    std::int32_t& cut = interval.cutBy[above0 ? 0 : 1];
    // k cuts away more than the field before if it is still above where that one ties
    if (cut < 0 || inner(cut).isBelow(k)) cut = k;
  }
  const auto [from, to] = interval.cutBy;
  if (from >= 0 && to >= 0 && inner(from).isBelow(to)) return std::nullopt;
  return interval;
}

template <std::size_t N>
std::array<std::int32_t, N> sortedWith(const std::array<std::int32_t, N - 1>& columns,
                                       std::int32_t k) {
  std::array<std::int32_t, N> out;
  std::ranges::copy(columns, out.begin());
  out[N - 1] = k;
  std::ranges::sort(out);
  return out;
}

template <class Item>
void sortUnique(std::vector<Item>& items) {
  std::ranges::sort(items);
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

std::vector<Triple> facePointsAmong(const FieldMatrix& fields, const Face& face,
                                    const Columns& seen) {
  std::vector<Triple> points;
  for (std::size_t x = 0; x < seen.size(); ++x) {
    for (std::size_t y = x + 1; y < seen.size(); ++y) {
      const Edge tied{seen[x], seen[y]};
      const auto chord = pairChord(fields, face, tied[0], tied[1]);
      if (!chord) continue;
      const auto interval = partOnTop(
          seen, TiedPoint<2>(fields, chord->end[0], tied),
          TiedPoint<2>(fields, chord->end[1], tied),
          [&](std::int32_t k) { return TiedPoint<3>(fields, face, sortedWith<3>(tied, k)); },
          [&](std::int32_t k) { return k == tied[0] || k == tied[1]; });
      if (!interval) continue;
      for (const std::int32_t k : interval->cutBy) {
        if (k >= 0) points.push_back(sortedWith<3>(tied, k));
      }
    }
  }
  sortUnique(points);
  return points;
}

std::vector<Quad> tetPointsAmong(const FieldMatrix& fields,
                                 const std::array<std::int32_t, 4>& corners, const Columns& seen) {
  std::vector<Quad> points;
  for (std::size_t x = 0; x < seen.size(); ++x) {
    for (std::size_t y = x + 1; y < seen.size(); ++y) {
      for (std::size_t z = y + 1; z < seen.size(); ++z) {
        const Triple tied{seen[x], seen[y], seen[z]};
        const auto chord = tripleChord(fields, corners, tied);
        if (!chord) continue;
        const auto interval = partOnTop(
            seen, TiedPoint<3>(fields, chord->end[0], tied),
            TiedPoint<3>(fields, chord->end[1], tied),
            [&](std::int32_t k) { return TiedPoint<4>(fields, corners, sortedWith<4>(tied, k)); },
            [&](std::int32_t k) { return k == tied[0] || k == tied[1] || k == tied[2]; });
        if (!interval) continue;
        for (const std::int32_t k : interval->cutBy) {
          if (k >= 0) points.push_back(sortedWith<4>(tied, k));
        }
      }
    }
  }
  sortUnique(points);
  return points;
}

/// A field that is not seen yet shows inside if and only if it is above at one of the points found
/// so far: against the largest of the seen ones it is linear on each of their cells, so largest at
/// a cell's corner, and the corners on the simplex's boundary were settled before. Adds such fields
/// to `seen`; false where there are none.
template <int N, class Point>
bool addOvertaking(const FieldMatrix& fields, const Candidates& candidates, Candidates::Columns out,
                   const std::array<std::int32_t, N>& vertices, const std::vector<Point>& points,
                   Columns& seen) {
  Columns found;
  for (const Point& p : points) {
    const TiedPoint<N> tied(fields, vertices, p);
    for (std::int32_t k = candidates.first(); k < candidates.end(); ++k) {
      if (contains(seen, k) || contains(out, k)) continue;
      if (tied.isBelow(k)) found.push_back(k);
    }
  }
  if (found.empty()) return false;
  seen.insert(seen.end(), found.begin(), found.end());
  sortUnique(seen);
  return true;
}

}  // namespace

std::vector<std::int32_t> ownersBetween(const FieldMatrix& fields, const Candidates& candidates,
                                        const Edge& edge, std::int32_t i, std::int32_t j) {
  const Candidates::Columns out = candidates.outOnEdge(edge[0], edge[1]);
  // Struck in every tet around the edge, yet on top at an end: all of those tets are conflicts and
  // will be cut anew. The two need not even cross here.
  if (contains(out, i) || contains(out, j)) return {};
  std::vector<std::int32_t> between;
  for (std::int32_t current = i; current != j;) {
    // Of all fields that are above the current one at b, the one that passes it first
    std::int32_t next = j;
    std::optional<TiedPoint<2>> passing;
    passing.emplace(fields, edge, Edge{current, next});
    for (std::int32_t k = candidates.first(); k < candidates.end(); ++k) {
      if (k == current || k == next || contains(out, k)) continue;
      if (!beatsAt(fields, edge[1], k, current) || !passing->isBelow(k)) continue;
      next = k;
      passing.emplace(fields, edge, Edge{current, next});
    }
    if (next != j) between.push_back(next);
    current = next;
  }
  return between;
}

std::vector<Triple> pointsOfFace(const FieldMatrix& fields, const Candidates& candidates,
                                 const Face& face, std::vector<std::int32_t>& seen) {
  const Candidates::Columns out = candidates.outOnFace(face[0], face[1], face[2]);
  while (true) {
    auto points = facePointsAmong(fields, face, seen);
    if (!addOvertaking<3>(fields, candidates, out, face, points, seen)) return points;
  }
}

std::vector<Quad> pointsOfTet(const FieldMatrix& fields, const Candidates& candidates,
                              std::int32_t tet, const std::array<std::int32_t, 4>& corners,
                              std::vector<std::int32_t>& seen) {
  if (seen.size() < 4) return {};
  const Candidates::Columns out = candidates.outInTet(tet);
  while (true) {
    auto points = tetPointsAmong(fields, corners, seen);
    if (!addOvertaking<4>(fields, candidates, out, corners, points, seen)) return points;
  }
}

}  // namespace ecorche::envelope
