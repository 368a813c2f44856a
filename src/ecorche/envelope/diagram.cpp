#include <ecorche/core/contract.h>
#include <ecorche/core/index.h>
#include <ecorche/envelope/collect.h>
#include <ecorche/envelope/diagram.h>
#include <ecorche/envelope/simplex_diagram.h>
#include <ecorche/envelope/tied_point.h>
#include <fmt/format.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

namespace ecorche::envelope {
namespace {

using mesh::kTetEdge;
using mesh::kTetFace;
using mesh::Tets;
using tissue::FieldMatrix;

/// The largest field at a vertex, ties by rank; -1 where one of them is not finite.
std::int32_t ownerOfVertex(const FieldMatrix& fields, const Candidates& candidates,
                           std::int32_t v) {
  const auto row = fields.row(v);
  if (!((row.array() * 0.0).sum() == 0.0)) return -1;
  const Candidates::Columns out = candidates.outAtVertex(v);
  std::int32_t best = -1;
  for (std::int32_t k = candidates.first(); k < candidates.end(); ++k) {
    if (!out.empty() && std::ranges::binary_search(out, k)) continue;
    if (best < 0 || beats(row[k], k, row[best], best)) best = k;
  }
  return best;
}

std::array<std::int32_t, 4> cornersOf(const Tets& T, std::int32_t t) {
  return {T(t, 0), T(t, 1), T(t, 2), T(t, 3)};
}

Edge edgeOf(const Tets& T, std::int32_t t, int e) {
  const std::int32_t a = T(t, kTetEdge[e][0]);
  const std::int32_t b = T(t, kTetEdge[e][1]);
  return {std::min(a, b), std::max(a, b)};
}

Face faceOf(const Tets& T, std::int32_t t, int k) {
  Face face{T(t, kTetFace[k][0]), T(t, kTetFace[k][1]), T(t, kTetFace[k][2])};
  std::ranges::sort(face);
  return face;
}

void addUnique(std::vector<std::int32_t>& sorted, std::int32_t value) {
  const auto place = std::ranges::lower_bound(sorted, value);
  if (place == sorted.end() || *place != value) sorted.insert(place, value);
}

/// Step 3: every mixed edge once, found by counting edges per lower vertex.
void listEdges(const Tets& T, Diagram& d) {
  std::vector<std::int32_t> first(toIndex(d.vertexCount()), 0);
  const auto forMixedEdges = [&](const auto& visit) {
    for (const std::int32_t t : d.mixed) {
      for (int e = 0; e < 6; ++e) {
        const Edge edge = edgeOf(T, t, e);
        if (d.owner[toIndex(edge[0])] != d.owner[toIndex(edge[1])]) visit(edge);
      }
    }
  };
  forMixedEdges([&](const Edge& edge) { ++first[toIndex(edge[0])]; });
  prefixSum(first);
  std::vector<std::int32_t> next(first.begin(), first.end() - 1);
  std::vector<std::int32_t> upper(toIndex(first.back()));
  forMixedEdges([&](const Edge& edge) { upper[toIndex(next[toIndex(edge[0])]++)] = edge[1]; });

  // The same edge was met from every tet around it
  std::vector<std::int32_t> edgesFrom(toIndex(d.vertexCount()), 0);
  parallelFor(d.vertexCount(), [&](std::int64_t v) {
    const auto begin = upper.begin() + first[toIndex(v)];
    const auto end = upper.begin() + first[toIndex(v) + 1];
    std::sort(begin, end);
    edgesFrom[toIndex(v)] = static_cast<std::int32_t>(std::unique(begin, end) - begin);
  });
  prefixSum(edgesFrom);
  d.edges.resize(toIndex(edgesFrom.back()));
  parallelFor(d.vertexCount(), [&](std::int64_t v) {
    for (std::int32_t e = edgesFrom[toIndex(v)]; e < edgesFrom[toIndex(v) + 1]; ++e) {
      d.edges[toIndex(e)] = {static_cast<std::int32_t>(v),
                             upper[toIndex(first[toIndex(v)] + e - edgesFrom[toIndex(v)])]};
    }
  });

  d.mixedEdges.resize(d.mixed.size());
  parallelFor(static_cast<std::int64_t>(d.mixed.size()), [&](std::int64_t m) {
    for (int e = 0; e < 6; ++e) {
      const Edge edge = edgeOf(T, d.mixed[toIndex(m)], e);
      std::int32_t index = -1;
      if (d.owner[toIndex(edge[0])] != d.owner[toIndex(edge[1])]) {
        index = edgesFrom[toIndex(edge[0])];
        while (d.edges[toIndex(index)][1] != edge[1]) ++index;
      }
      d.mixedEdges[toIndex(m)][toIndex(e)] = index;
    }
  });
}

/// Step 4: the envelope along every mixed edge.
void crossEdges(const FieldMatrix& fields, const Candidates& candidates, Diagram& d) {
  const auto edgeCount = static_cast<std::int64_t>(d.edges.size());
  d.edgeFirst.assign(d.edges.size(), 1);
  const auto between = collect<std::int32_t>(edgeCount, [&](std::int64_t e, auto& out) {
    const Edge& edge = d.edges[toIndex(e)];
    const std::int32_t i = d.owner[toIndex(edge[0])];
    const std::int32_t j = d.owner[toIndex(edge[1])];
    // Nearly always nothing else comes near the crossing
    if (fieldsNotBelowCrossing(fields, edge[0], edge[1], i, j, candidates.first()) == 2) return;
    const auto owners = ownersBetween(fields, candidates, edge, i, j);
    d.edgeFirst[toIndex(e)] += static_cast<std::int32_t>(owners.size());
    out.insert(out.end(), owners.begin(), owners.end());
  });
  prefixSum(d.edgeFirst);
  d.labelAfter.resize(toIndex(d.edgeFirst.back()));
  auto next = between.begin();
  for (std::int64_t e = 0; e < edgeCount; ++e) {
    const std::int32_t last = d.edgeFirst[toIndex(e) + 1] - 1;
    for (std::int32_t c = d.edgeFirst[toIndex(e)]; c < last; ++c)
      d.labelAfter[toIndex(c)] = *next++;
    d.labelAfter[toIndex(last)] = d.owner[toIndex(d.edges[toIndex(e)][1])];
  }
}

/// Owners on some edges of a mixed tet, ascending.
void addOwnersOnEdge(const Diagram& d, std::int32_t e, std::vector<std::int32_t>& owners) {
  addUnique(owners, d.owner[toIndex(d.edges[toIndex(e)][0])]);
  for (std::int32_t c = d.edgeFirst[toIndex(e)]; c < d.edgeFirst[toIndex(e) + 1]; ++c) {
    addUnique(owners, d.labelAfter[toIndex(c)]);
  }
}

/// Step 5: where only two fields own corners and edge points nothing else can show inside.
void findComplexTets(Diagram& d) {
  d.complexOf.assign(d.mixed.size(), -1);
  d.complex = collect<std::int32_t>(
      static_cast<std::int64_t>(d.mixed.size()), [&](std::int64_t m, auto& out) {
        std::int32_t owners[3];
        int count = 0;
        const auto see = [&](std::int32_t owner) {
          for (int i = 0; i < count; ++i) {
            if (owners[i] == owner) return;
          }
          if (count < 3) owners[count++] = owner;
        };
        for (const std::int32_t e : d.mixedEdges[toIndex(m)]) {
          if (e < 0) continue;
          see(d.owner[toIndex(d.edges[toIndex(e)][0])]);
          for (std::int32_t c = d.edgeFirst[toIndex(e)]; c < d.edgeFirst[toIndex(e) + 1]; ++c)
            see(d.labelAfter[toIndex(c)]);
        }
        if (count > 2) out.push_back(static_cast<std::int32_t>(m));
      });
  for (std::size_t x = 0; x < d.complex.size(); ++x) {
    d.complexOf[toIndex(d.complex[x])] = static_cast<std::int32_t>(x);
  }
}

/// Owners on the three edges of a face opposite corner k of a mixed tet, ascending.
std::vector<std::int32_t> ownersAroundFace(const Diagram& d, std::int32_t m, int k) {
  std::vector<std::int32_t> owners;
  for (int e = 0; e < 6; ++e) {
    const std::int32_t edge = d.mixedEdges[toIndex(m)][toIndex(e)];
    if (edge >= 0 && kTetEdge[e][0] != k && kTetEdge[e][1] != k) addOwnersOnEdge(d, edge, owners);
  }
  return owners;
}

/// A face of a tet with three or more owners.
struct Slot {
  Face face;
  std::int32_t slot;  ///< 4·(index into complex) + corner
  auto operator<=>(const Slot&) const = default;
};

/// Step 6: the points of every face that has three or more owners on its edges.
void crossFaces(const Tets& T, const FieldMatrix& fields, const Candidates& candidates,
                Diagram& d) {
  auto slots = collect<Slot>(
      static_cast<std::int64_t>(d.complex.size()),
      [&](std::int64_t x, auto& out) {
        const std::int32_t m = d.complex[toIndex(x)];
        for (int k = 0; k < 4; ++k) {
          if (ownersAroundFace(d, m, k).size() < 3) continue;
          out.push_back({faceOf(T, d.mixed[toIndex(m)], k), static_cast<std::int32_t>(4 * x + k)});
        }
      },
      64);
  tbb::parallel_sort(slots.begin(), slots.end());
  d.complexFaces.assign(d.complex.size(), {-1, -1, -1, -1});
  std::vector<std::int32_t> anySlot;
  for (const Slot& s : slots) {
    if (d.faces.empty() || d.faces.back() != s.face) {
      d.faces.push_back(s.face);
      anySlot.push_back(s.slot);
    }
    d.complexFaces[toIndex(s.slot / 4)][toIndex(s.slot % 4)] =
        static_cast<std::int32_t>(d.faces.size()) - 1;
  }
  d.faceFirst.assign(d.faces.size(), 0);
  d.facePoints = collect<Triple>(
      static_cast<std::int64_t>(d.faces.size()),
      [&](std::int64_t f, auto& out) {
        auto seen = ownersAroundFace(d, d.complex[toIndex(anySlot[toIndex(f)] / 4)],
                                     anySlot[toIndex(f)] % 4);
        const auto points = pointsOfFace(fields, candidates, d.faces[toIndex(f)], seen);
        d.faceFirst[toIndex(f)] = static_cast<std::int32_t>(points.size());
        out.insert(out.end(), points.begin(), points.end());
      },
      64);
  prefixSum(d.faceFirst);
}

/// Owners on the boundary of a tet with three or more, ascending.
std::vector<std::int32_t> ownersOnBoundary(const Diagram& d, std::int32_t x) {
  std::vector<std::int32_t> owners;
  for (const std::int32_t e : d.mixedEdges[toIndex(d.complex[toIndex(x)])]) {
    if (e >= 0) addOwnersOnEdge(d, e, owners);
  }
  for (const std::int32_t f : d.complexFaces[toIndex(x)]) {
    if (f < 0) continue;
    for (std::int32_t p = d.faceFirst[toIndex(f)]; p < d.faceFirst[toIndex(f) + 1]; ++p) {
      for (const std::int32_t column : d.facePoints[toIndex(p)]) addUnique(owners, column);
    }
  }
  return owners;
}

/// Step 7: the points inside tets.
void crossTets(const Tets& T, const FieldMatrix& fields, const Candidates& candidates, Diagram& d) {
  d.tetFirst.assign(d.complex.size(), 0);
  d.tetPoints = collect<Quad>(
      static_cast<std::int64_t>(d.complex.size()),
      [&](std::int64_t x, auto& out) {
        const std::int32_t t = d.mixed[toIndex(d.complex[toIndex(x)])];
        auto corners = cornersOf(T, t);
        std::ranges::sort(corners);
        auto seen = ownersOnBoundary(d, static_cast<std::int32_t>(x));
        const auto points = pointsOfTet(fields, candidates, t, corners, seen);
        d.tetFirst[toIndex(x)] = static_cast<std::int32_t>(points.size());
        out.insert(out.end(), points.begin(), points.end());
      },
      64);
  prefixSum(d.tetFirst);
}

/// Struck tissues that own something on the boundary of the tet that strikes them.
void findConflicts(const Tets& T, const Candidates& candidates, Diagram& d) {
  for (const auto& [t, columns] : candidates.struckTets()) {
    std::vector<std::int32_t> owners;
    const auto m = std::ranges::lower_bound(d.mixed, t);
    if (m == d.mixed.end() || *m != t) {
      owners.push_back(d.owner[toIndex(T(t, 0))]);
    } else {
      const auto i = toIndex(m - d.mixed.begin());
      for (const std::int32_t e : d.mixedEdges[i]) {
        if (e >= 0) addOwnersOnEdge(d, e, owners);
      }
      if (d.complexOf[i] >= 0) owners = ownersOnBoundary(d, d.complexOf[i]);
    }
    for (const std::int32_t column : columns) {
      if (std::ranges::binary_search(owners, column)) {
        d.conflicts.push_back({t, TissueId(column + kFat.value)});
      }
    }
  }
}

}  // namespace

Result<Diagram> computeDiagram(const Tets& T, const FieldMatrix& fields,
                               const Candidates& candidates, RunContext& run) {
  EC_REQUIRE_EQ(candidates.end(), static_cast<std::int32_t>(fields.cols()));
  EC_REQUIRE(T.size() == 0 || T.maxCoeff() < fields.rows());
  const auto cancelled = [] { return fail(ErrorCode::Cancelled, "envelope: cancelled"); };

  // 1. One owner per vertex
  Diagram d;
  d.owner.resize(toIndex(fields.rows()));
  parallelFor(fields.rows(), [&](std::int64_t v) {
    d.owner[toIndex(v)] = ownerOfVertex(fields, candidates, static_cast<std::int32_t>(v));
  });
  if (const auto bad = std::ranges::find(d.owner, -1); bad != d.owner.end()) {
    const auto v = bad - d.owner.begin();
    Eigen::Index column = 0;
    while (std::isfinite(fields(v, column))) ++column;
    return fail(ErrorCode::NonFiniteField, fmt::format("the field of tissue {} is {} at vertex {}",
                                                       column + kFat.value, fields(v, column), v));
  }
  if (run.cancelled()) return cancelled();

  // 2. Tets whose corners agree are done: fields are linear, nothing can rise above inside
  d.mixed = collect<std::int32_t>(
      T.rows(),
      [&](std::int64_t t, auto& out) {
        const std::int32_t first = d.owner[toIndex(T(t, 0))];
        if (d.owner[toIndex(T(t, 1))] != first || d.owner[toIndex(T(t, 2))] != first ||
            d.owner[toIndex(T(t, 3))] != first) {
          out.push_back(static_cast<std::int32_t>(t));
        }
      },
      8192);

  listEdges(T, d);
  if (run.cancelled()) return cancelled();
  crossEdges(fields, candidates, d);
  findComplexTets(d);
  if (run.cancelled()) return cancelled();
  crossFaces(T, fields, candidates, d);
  if (run.cancelled()) return cancelled();
  crossTets(T, fields, candidates, d);
  findConflicts(T, candidates, d);
  return d;
}

std::vector<std::int32_t> ownersOnFace(const Tets& T, const Diagram& d, std::int32_t m, int k) {
  auto owners = ownersAroundFace(d, m, k);
  if (owners.empty()) return {d.owner[toIndex(T(d.mixed[toIndex(m)], kTetFace[k][0]))]};
  const std::int32_t x = d.complexOf[toIndex(m)];
  const std::int32_t f = x < 0 ? -1 : d.complexFaces[toIndex(x)][toIndex(k)];
  if (f < 0) return owners;
  for (std::int32_t p = d.faceFirst[toIndex(f)]; p < d.faceFirst[toIndex(f) + 1]; ++p) {
    for (const std::int32_t column : d.facePoints[toIndex(p)]) addUnique(owners, column);
  }
  return owners;
}

std::vector<std::vector<std::int32_t>> ownersOfComplexTets(const Diagram& d) {
  std::vector<std::vector<std::int32_t>> owners(d.complex.size());
  parallelFor(
      static_cast<std::int64_t>(d.complex.size()),
      [&](std::int64_t x) {
        owners[toIndex(x)] = ownersOnBoundary(d, static_cast<std::int32_t>(x));
        for (std::int32_t p = d.tetFirst[toIndex(x)]; p < d.tetFirst[toIndex(x) + 1]; ++p) {
          for (const std::int32_t column : d.tetPoints[toIndex(p)])
            addUnique(owners[toIndex(x)], column);
        }
      },
      64);
  return owners;
}

}  // namespace ecorche::envelope
