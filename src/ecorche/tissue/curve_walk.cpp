#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/curve_walk.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace ecorche::tissue {

using domain::BoundaryTag;
using mesh::Vector3;

// One chord walked: the tets it crosses with the share of the chord where each begins, and where it
// ended.
struct CurveWalker::Leg {
  struct Crossing {
    std::int32_t tet;
    double s0;
    double s1;
  };
  std::vector<Crossing> crossings;
  std::int32_t tet = -1;           // holds the chord's end; -1: the chord left the domain
  double s = 1.0;                  // where it left
  std::optional<BoundaryTag> tag;  // through what; unset: the walk was lost and ended outside
};

CurveWalker::CurveWalker(const domain::Domain& domain)
    : domain_(domain),
      locator_(domain.mesh),
      meanEdges_(mesh::meanEdgeLengths(domain.mesh)),
      wells_(domain) {
  outsideStep_ = meanEdges_.size() > 0 ? 0.25 * meanEdges_.mean() : 1.0;

  // Boundary faces by (tet, corner opposite)
  const auto count = static_cast<std::size_t>(domain.boundaryF.rows());
  std::vector<std::int32_t> slot(count);
  for (std::size_t f = 0; f < count; ++f) {
    const std::int32_t t = domain.boundaryTet[f];
    const auto face = domain.boundaryF.row(static_cast<Eigen::Index>(f));
    int k = 0;
    while (k < 3 && (face.array() == domain.mesh.T(t, k)).any()) ++k;
    slot[f] = 4 * t + k;
  }
  tagFace_.resize(count);
  std::iota(tagFace_.begin(), tagFace_.end(), 0);
  std::ranges::sort(tagFace_, {},
                    [&](std::int32_t f) { return slot[static_cast<std::size_t>(f)]; });
  tagSlot_.reserve(count);
  for (const std::int32_t f : tagFace_) tagSlot_.push_back(slot[static_cast<std::size_t>(f)]);
}

BoundaryTag CurveWalker::tagOf(std::int32_t tet, int corner) const {
  const auto at = std::ranges::lower_bound(tagSlot_, 4 * tet + corner) - tagSlot_.begin();
  return domain_.boundaryTag[static_cast<std::size_t>(tagFace_[static_cast<std::size_t>(at)])];
}

CurveWalker::Leg CurveWalker::leg(std::int32_t tet, const Vector3& p, const Vector3& q) const {
  constexpr int kPatience =
      64;  // steps without progress: the chord runs along an edge or through a vertex
  Leg out;
  double s = 0.0;
  int cameThrough = -1;
  for (int stuck = 0; stuck < kPatience;) {
    const Eigen::Vector4d atQ = mesh::barycentric(domain_.mesh, tet, q);
    if (atQ.minCoeff() >= 0.0) {
      out.crossings.push_back({tet, s, 1.0});
      out.tet = tet;
      return out;
    }
    // The first face on the way from p to q, among those that have q behind them
    const Eigen::Vector4d atP = mesh::barycentric(domain_.mesh, tet, p);
    int exit = -1;
    double first = 2.0;
    for (int k = 0; k < 4; ++k) {
      if (k == cameThrough || !(atQ[k] < 0.0)) continue;
      const double share = atP[k] > 0.0 ? atP[k] / (atP[k] - atQ[k]) : 0.0;
      if (share < first) {
        first = share;
        exit = k;
      }
    }
    if (exit < 0) break;
    const double next = std::clamp(first, s, 1.0);
    if (next > s) out.crossings.push_back({tet, s, next});
    stuck = next > s ? 0 : stuck + 1;
    s = next;
    const std::int32_t neighbour = domain_.neighbours(tet, exit);
    if (neighbour < 0) {
      out.s = s;
      out.tag = tagOf(tet, exit);
      return out;
    }
    cameThrough = 0;
    while (domain_.neighbours(neighbour, cameThrough) != tet) ++cameThrough;
    tet = neighbour;
  }
  // Lost: the grid says where the chord's end is; what is left of the chord counts to that tet
  out.tet = locator_.locate(q);
  out.s = s;
  if (out.tet >= 0 && s < 1.0) out.crossings.push_back({out.tet, s, 1.0});
  return out;
}

std::int32_t CurveWalker::find(std::int32_t from, const Vector3& p) const {
  if (from < 0) return locator_.locate(p);
  const Vector3 centre =
      domain_.mesh.V(domain_.mesh.T.row(from), Eigen::all).colwise().mean().transpose();
  const Leg direct = leg(from, centre, p);
  return direct.tet >= 0 ? direct.tet : locator_.locate(p);
}

CurveWalk CurveWalker::walk(const mesh::Spline& spline) const {
  CurveWalk out;
  const double last = spline.lastParameter();
  double u = 0.0;
  Vector3 p = spline.at(0.0);
  std::int32_t tet = locator_.locate(p);
  if (tet < 0) out.gaps.push_back({0.0, 0.0, {}, {}});

  const auto addPiece = [&](std::int32_t t, double u0, double u1) {
    if (!(u1 > u0)) return;
    if (!out.pieces.empty() && out.pieces.back().tet == t && out.pieces.back().u1 == u0) {
      out.pieces.back().u1 = u1;
    } else {
      out.pieces.push_back({t, u0, u1});
    }
  };

  while (u < last) {
    // A chord of a quarter of the tet we are in, shorter where the curve bends away from it
    const double step = tet >= 0 ? 0.25 * meanEdges_[tet] : outsideStep_;
    const double speed = spline.derivative(u).norm();
    double next = std::min(last, u + std::max(speed > 0.0 ? step / speed : 0.0, 1e-6 * last));
    Vector3 q = spline.at(next);
    for (int halvings = 0; halvings < 6; ++halvings) {
      const Vector3 bow = spline.at(0.5 * (u + next)) - 0.5 * (p + q);
      if (bow.norm() <= 0.02 * step) break;
      next = 0.5 * (u + next);
      q = spline.at(next);
    }
    const auto along = [&](double s) { return s >= 1.0 ? next : u + s * (next - u); };

    double reached = u;  // up to where pieces and gaps are known
    bool inside = tet >= 0;
    if (inside) {
      const Leg forward = leg(tet, p, q);
      for (const auto& c : forward.crossings) addPiece(c.tet, along(c.s0), along(c.s1));
      tet = forward.tet;
      if (tet < 0) {
        reached = along(forward.s);
        out.gaps.push_back({reached, reached, forward.tag, {}});
        inside = false;
      }
    }
    if (!inside) {
      // Back in at the chord's end? Then the way in is found by walking backward from there
      tet = locator_.locate(q);
      if (tet >= 0) {
        const Leg backward = leg(tet, q, p);
        double entry = backward.tet >= 0 ? reached : along(1.0 - backward.s);
        entry = std::max(entry, reached);
        out.gaps.back().u1 = entry;
        if (backward.tet < 0) out.gaps.back().entry = backward.tag;
        for (auto c = backward.crossings.rbegin(); c != backward.crossings.rend(); ++c) {
          addPiece(c->tet, std::max(entry, along(1.0 - c->s1)), along(1.0 - c->s0));
        }
      } else {
        out.gaps.back().u1 = next;
      }
    }
    u = next;
    p = q;
  }
  std::erase_if(out.gaps, [](const CurveGap& gap) { return !(gap.u1 > gap.u0); });
  return out;
}

}  // namespace ecorche::tissue
