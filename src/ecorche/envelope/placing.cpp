#include <ecorche/core/contract.h>
#include <ecorche/core/index.h>
#include <ecorche/core/parallel.h>
#include <ecorche/envelope/placing.h>
#include <ecorche/envelope/tied_point.h>

#include <Eigen/Dense>
#include <algorithm>

namespace ecorche::envelope {
namespace {

using mesh::Tets;
using tissue::FieldMatrix;
using Origin = Anatomy::Origin;

std::array<std::int32_t, 4> sortedCorners(const Tets& T, std::int32_t t) {
  std::array<std::int32_t, 4> corners{T(t, 0), T(t, 1), T(t, 2), T(t, 3)};
  std::ranges::sort(corners);
  return corners;
}

/// Where i (on top at a) and j (on top at b) cross, as weight of b.
double crossingOf(const FieldMatrix& fields, const Edge& edge, std::int32_t i, std::int32_t j) {
  const double atA = fields(edge[0], i) - fields(edge[0], j);
  const double atB = fields(edge[1], j) - fields(edge[1], i);
  return std::clamp(atA / (atA + atB), 0.0, 1.0);
}

/// Keeps rising values in [gap, 1 − gap] and gap apart.
void spread(std::vector<double>& t, double clamp) {
  const double gap = std::min(clamp, 0.5 / (static_cast<double>(t.size()) + 1.0));
  double lowest = gap;
  for (double& x : t) {
    x = std::max(x, lowest);
    lowest = x + gap;
  }
  double highest = 1.0 - gap;
  for (auto x = t.rbegin(); x != t.rend(); ++x) {
    *x = std::min(*x, highest);
    highest = *x - gap;
  }
}

template <int N>
Origin originOf(const std::array<std::int32_t, N>& corners, const std::array<double, N>& weight) {
  Origin o;
  std::copy(corners.begin(), corners.end(), o.corner.begin());
  std::copy(weight.begin(), weight.end(), o.weight.begin());
  return o;
}

/// Weights of at least `clamp` (0: only what rounding left below zero is lifted), sum 1; true where
/// they changed.
template <int N>
bool liftWeights(std::array<double, N>& weight, double clamp) {
  constexpr double kRounding = 1e-11;
  bool moved = false;
  double sum = 0.0;
  for (double& w : weight) {
    if (w < clamp) {
      moved |= w < clamp - kRounding;
      w = clamp;
    }
    sum += w;
  }
  for (double& w : weight) w /= sum;
  return moved;
}

template <int N>
void placeTied(const FieldMatrix& fields, const std::array<std::int32_t, N>& corners,
               const std::array<std::int32_t, N>& tied, std::optional<double> clamp, Origin& origin,
               Placed& placed) {
  auto weight = TiedPoint<N>(fields, corners, tied).barycentric();
  if (liftWeights<N>(weight, clamp.value_or(0.0))) placed = Placed::Clamped;
  origin = originOf<N>(corners, weight);
}

void placeEdge(const FieldMatrix& fields, const Diagram& d, std::int32_t e,
               std::optional<double> clamp, Placement& out) {
  const Edge& edge = d.edges[toIndex(e)];
  std::vector<double> raw;
  for (std::int32_t c = d.edgeFirst[toIndex(e)]; c < d.edgeFirst[toIndex(e) + 1]; ++c) {
    raw.push_back(crossingOf(fields, edge, d.labelBefore(e, c), d.labelAfter[toIndex(c)]));
    // Rounding must not swap what exact signs have ordered
    if (raw.size() > 1) raw.back() = std::max(raw.back(), raw[raw.size() - 2]);
  }
  std::vector<double> t = raw;
  if (clamp) spread(t, *clamp);
  for (std::size_t n = 0; n < t.size(); ++n) {
    const std::size_t k = toIndex(d.edgeFirst[toIndex(e)]) + n;
    out.origin[k] = originOf<2>(edge, {1.0 - t[n], t[n]});
    if (t[n] != raw[n]) out.placed[k] = Placed::Clamped;
  }
}

/// Free points at the mean of their neighbours, fixed ones where they are. Rows of weights over the
/// same corners.
template <int N>
std::vector<std::array<double, N>> relaxed(const std::vector<std::vector<std::int32_t>>& neighbours,
                                           const std::vector<std::array<double, N>>& fixed) {
  // Neighbour index below #fixed is a fixed point, beyond it a free one
  const auto count = static_cast<Eigen::Index>(neighbours.size());
  const auto fixedCount = static_cast<Eigen::Index>(fixed.size());
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(count, N);
  for (Eigen::Index p = 0; p < count; ++p) {
    L(p, p) = static_cast<double>(neighbours[toIndex(p)].size());
    for (const std::int32_t n : neighbours[toIndex(p)]) {
      if (n >= fixedCount) {
        L(p, n - fixedCount) -= 1.0;
      } else {
        for (int c = 0; c < N; ++c) rhs(p, c) += fixed[toIndex(n)][toIndex(c)];
      }
    }
  }
  const Eigen::MatrixXd x = L.partialPivLu().solve(rhs);
  std::vector<std::array<double, N>> out(neighbours.size());
  for (Eigen::Index p = 0; p < count; ++p) {
    for (int c = 0; c < N; ++c) out[toIndex(p)][toIndex(c)] = x(p, c);
  }
  return out;
}

template <std::size_t A, std::size_t B>
int common(const std::array<std::int32_t, A>& a, const std::array<std::int32_t, B>& b) {
  int count = 0;
  for (const std::int32_t x : a) count += std::ranges::find(b, x) != b.end();
  return count;
}

/// Weights of an origin over a larger simplex's corners.
template <int N>
std::array<double, N> over(const std::array<std::int32_t, N>& corners, const Origin& origin) {
  std::array<double, N> weight{};
  for (int c = 0; c < 4; ++c) {
    if (origin.corner[toIndex(c)] < 0) continue;
    weight[toIndex(std::ranges::find(corners, origin.corner[toIndex(c)]) - corners.begin())] +=
        origin.weight[toIndex(c)];
  }
  return weight;
}

}  // namespace

Placement placeNames(const Tets& T, const FieldMatrix& fields, const Diagram& d,
                     std::optional<double> clamp) {
  Placement out;
  out.origin.resize(toIndex(d.newVertexCount()));
  out.placed.assign(toIndex(d.newVertexCount()), Placed::Exact);
  const std::int32_t base = d.vertexCount();

  parallelFor(static_cast<std::int64_t>(d.edges.size()), [&](std::int64_t e) {
    placeEdge(fields, d, static_cast<std::int32_t>(e), clamp, out);
  });
  parallelFor(
      static_cast<std::int64_t>(d.faces.size()),
      [&](std::int64_t f) {
        for (std::int32_t p = d.faceFirst[toIndex(f)]; p < d.faceFirst[toIndex(f) + 1]; ++p) {
          const auto k = toIndex(d.facePointId(p) - base);
          placeTied<3>(fields, d.faces[toIndex(f)], d.facePoints[toIndex(p)], clamp, out.origin[k],
                       out.placed[k]);
        }
      },
      64);
  parallelFor(
      static_cast<std::int64_t>(d.complex.size()),
      [&](std::int64_t x) {
        const auto corners = sortedCorners(T, d.mixed[toIndex(d.complex[toIndex(x)])]);
        for (std::int32_t p = d.tetFirst[toIndex(x)]; p < d.tetFirst[toIndex(x) + 1]; ++p) {
          const auto k = toIndex(d.tetPointId(p) - base);
          placeTied<4>(fields, corners, d.tetPoints[toIndex(p)], clamp, out.origin[k],
                       out.placed[k]);
        }
      },
      64);
  return out;
}

std::int32_t SafePlaces::edgeIndex(std::int32_t a, std::int32_t b) const {
  const Edge edge{std::min(a, b), std::max(a, b)};
  const auto found = std::ranges::lower_bound(d_.edges, edge);
  return found != d_.edges.end() && *found == edge
             ? static_cast<std::int32_t>(found - d_.edges.begin())
             : -1;
}

Origin SafePlaces::ofCrossing(std::int32_t edge, std::int32_t crossing) const {
  const double steps = d_.edgeFirst[toIndex(edge) + 1] - d_.edgeFirst[toIndex(edge)] + 1;
  const double t = (crossing - d_.edgeFirst[toIndex(edge)] + 1) / steps;
  return originOf<2>(d_.edges[toIndex(edge)], {1.0 - t, t});
}

std::vector<Origin> SafePlaces::ofFace(std::int32_t face) const {
  const Face& corners = d_.faces[toIndex(face)];
  std::vector<std::array<double, 3>> fixed;
  std::vector<std::array<std::int32_t, 2>> fixedTied;
  for (int c = 0; c < 3; ++c) {
    const std::int32_t e = edgeIndex(corners[toIndex(c)], corners[toIndex((c + 1) % 3)]);
    if (e < 0) continue;
    for (std::int32_t x = d_.edgeFirst[toIndex(e)]; x < d_.edgeFirst[toIndex(e) + 1]; ++x) {
      fixed.push_back(over<3>(corners, ofCrossing(e, x)));
      fixedTied.push_back({d_.labelBefore(e, x), d_.labelAfter[toIndex(x)]});
    }
  }
  // Neighbours on a face share two of the three fields
  const std::int32_t begin = d_.faceFirst[toIndex(face)];
  const std::int32_t end = d_.faceFirst[toIndex(face) + 1];
  std::vector<std::vector<std::int32_t>> neighbours;
  for (std::int32_t p = begin; p < end; ++p) {
    auto& list = neighbours.emplace_back();
    for (std::size_t n = 0; n < fixed.size(); ++n) {
      if (common(fixedTied[n], d_.facePoints[toIndex(p)]) == 2)
        list.push_back(static_cast<std::int32_t>(n));
    }
    for (std::int32_t q = begin; q < end; ++q) {
      if (q != p && common(d_.facePoints[toIndex(q)], d_.facePoints[toIndex(p)]) == 2) {
        list.push_back(static_cast<std::int32_t>(fixed.size()) + q - begin);
      }
    }
  }
  std::vector<Origin> out;
  for (const auto& weight : relaxed<3>(neighbours, fixed))
    out.push_back(originOf<3>(corners, weight));
  return out;
}

std::vector<Origin> SafePlaces::ofTet(std::int32_t x) const {
  const auto corners = sortedCorners(T_, d_.mixed[toIndex(d_.complex[toIndex(x)])]);
  std::vector<std::array<double, 4>> fixed;
  std::vector<Triple> fixedTied;
  for (const std::int32_t f : d_.complexFaces[toIndex(x)]) {
    if (f < 0) continue;
    const auto places = ofFace(f);
    for (std::size_t n = 0; n < places.size(); ++n) {
      fixed.push_back(over<4>(corners, places[n]));
      fixedTied.push_back(d_.facePoints[toIndex(d_.faceFirst[toIndex(f)]) + n]);
    }
  }
  // Neighbours in a tet share three of the four fields
  const std::int32_t begin = d_.tetFirst[toIndex(x)];
  const std::int32_t end = d_.tetFirst[toIndex(x) + 1];
  std::vector<std::vector<std::int32_t>> neighbours;
  for (std::int32_t p = begin; p < end; ++p) {
    auto& list = neighbours.emplace_back();
    for (std::size_t n = 0; n < fixed.size(); ++n) {
      if (common(fixedTied[n], d_.tetPoints[toIndex(p)]) == 3)
        list.push_back(static_cast<std::int32_t>(n));
    }
    for (std::int32_t q = begin; q < end; ++q) {
      if (q != p && common(d_.tetPoints[toIndex(q)], d_.tetPoints[toIndex(p)]) == 3) {
        list.push_back(static_cast<std::int32_t>(fixed.size()) + q - begin);
      }
    }
  }
  std::vector<Origin> out;
  for (const auto& weight : relaxed<4>(neighbours, fixed))
    out.push_back(originOf<4>(corners, weight));
  return out;
}

Origin blend(const Origin& a, const Origin& b, double share) {
  EC_ASSERT(a.corner == b.corner, "origins over different corners");
  Origin out = a;
  for (std::size_t c = 0; c < 4; ++c)
    out.weight[c] = (1.0 - share) * a.weight[c] + share * b.weight[c];
  return out;
}

}  // namespace ecorche::envelope
