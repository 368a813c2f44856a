#include <ecorche/core/index.h>
#include <ecorche/domain/carried_samples.h>
#include <ecorche/domain/crossing_watch.h>
#include <ecorche/domain/half_edges.h>
#include <ecorche/domain/resample.h>
#include <ecorche/domain/triangle_tree.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <queue>

namespace ecorche::domain {

using mesh::Vector3;

namespace {

constexpr double kSharpDeg = 60.0;  // ridges bent by more than this stay ridges

/// 1 for an equilateral triangle, 0 for one without area.
double quality(const Vector3& a, const Vector3& b, const Vector3& c) {
  const double sum = (b - a).squaredNorm() + (c - b).squaredNorm() + (a - c).squaredNorm();
  return sum > 0.0 ? 2.0 * std::numbers::sqrt3 * (b - a).cross(c - a).norm() / sum : 0.0;
}

enum class Freedom : std::uint8_t { Surface, Curve, None };

class Resampler {
 public:
  Resampler(HalfEdges he, const TaggedSurface& old, const std::vector<CutPlane>& cutPlanes,
            const ResampleOptions& options)
      : he_(std::move(he)),
        cutPlanes_(cutPlanes),
        options_(options),
        samples_(old, options.spacing, options.loss) {
    if (options.watched) watch_.emplace(old);
    for (Eigen::Index v = 0; v < old.V.rows(); ++v) place(old.V.row(v).transpose());
    std::map<std::int32_t, std::vector<Eigen::Index>> facesOfTag;
    for (Eigen::Index f = 0; f < old.F.rows(); ++f) {
      facesOfTag[old.tag[static_cast<std::size_t>(f)]].push_back(f);
    }
    for (const auto& [tag, faces] : facesOfTag) {
      mesh::Triangles F(static_cast<Eigen::Index>(faces.size()), 3);
      for (std::size_t i = 0; i < faces.size(); ++i) {
        F.row(static_cast<Eigen::Index>(i)) = old.F.row(faces[i]);
      }
      trees_.emplace(tag, TriangleTree(old.V, F));
    }
    findFeatures();
  }

  Result<TaggedSurface> operator()(RunContext& run) {
    for (int round = 0; round < options_.rounds; ++round) {
      if (run.cancelled()) return fail(ErrorCode::Cancelled, "resampling surfaces");
      splitLong();
      collapseShort();
      flipEdges();
      relax();
    }
    collapseShort();
    flipEdges();
    return he_.toSurface(position_);
  }

 private:
  void place(const Vector3& p) {
    position_.push_back(p);
    wanted_.push_back(options_.edgeLength(p));
    tolerance_.push_back(options_.tolerance(p));
    watched_.push_back(options_.watched && options_.watched(p));
  }
  const Vector3& pos(std::int32_t v) const { return position_[toIndex(v)]; }
  double length(std::int32_t h) const { return (pos(he_.to(h)) - pos(he_.from(h))).norm(); }
  double wanted(std::int32_t h) const {
    return std::min(wanted_[toIndex(he_.to(h))], wanted_[toIndex(he_.from(h))]);
  }
  bool isFeature(std::int32_t h) const { return feature_[toIndex(h / 2)] != 0; }
  Vector3 normal(std::int32_t h) const {
    const Vector3& a = pos(he_.from(h));
    return (pos(he_.to(h)) - a).cross(pos(he_.apex(h)) - a);
  }

  // Features: edges between tags and sharp ridges. Ridges shorter than a few edges are noise of the
  // scan.
  void findFeatures() {
    const double sharp = std::cos(kSharpDeg * std::numbers::pi / 180.0);
    feature_.assign(toIndex(he_.halfEdgeCount() / 2), 0);
    std::vector<std::int32_t> ridges;
    for (std::int32_t h = 0; h < he_.halfEdgeCount(); h += 2) {
      const std::int32_t o = HalfEdges::opposite(h);
      if (he_.tag(h) != he_.tag(o)) {
        feature_[toIndex(h / 2)] = 1;
        continue;
      }
      const Vector3 n = normal(h);
      const Vector3 m = normal(o);
      if (n.dot(m) < sharp * n.norm() * m.norm()) ridges.push_back(h);
    }
    keepLongRidges(ridges);

    freedom_.assign(position_.size(), Freedom::Surface);
    std::vector<std::array<std::int32_t, 2>> segments;
    for (std::int32_t v = 0; v < he_.vertexCount(); ++v) {
      if (he_.vertexAlive(v)) freedom_[toIndex(v)] = freedomOf(v);
    }
    for (std::int32_t h = 0; h < he_.halfEdgeCount(); h += 2) {
      if (isFeature(h)) segments.push_back({he_.from(h), he_.to(h)});
    }
    mesh::Positions V(static_cast<Eigen::Index>(position_.size()), 3);
    for (std::size_t v = 0; v < position_.size(); ++v) {
      V.row(static_cast<Eigen::Index>(v)) = position_[v].transpose();
    }
    mesh::Triangles S(static_cast<Eigen::Index>(segments.size()), 3);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      S.row(static_cast<Eigen::Index>(s)) << segments[s][0], segments[s][1], segments[s][1];
    }
    curves_ = TriangleTree(V, S);
  }

  void keepLongRidges(const std::vector<std::int32_t>& ridges) {
    std::vector<std::int32_t> root(position_.size());
    for (std::size_t v = 0; v < root.size(); ++v) root[v] = static_cast<std::int32_t>(v);
    const auto find = [&](std::int32_t v) {
      while (root[toIndex(v)] != v) v = root[toIndex(v)] = root[toIndex(root[toIndex(v)])];
      return v;
    };
    for (const std::int32_t h : ridges) root[toIndex(find(he_.from(h)))] = find(he_.to(h));
    std::vector<double> total(position_.size(), 0.0);
    for (const std::int32_t h : ridges) total[toIndex(find(he_.from(h)))] += length(h);
    for (const std::int32_t h : ridges) {
      if (total[toIndex(find(he_.from(h)))] > 6.0 * wanted(h)) feature_[toIndex(h / 2)] = 1;
    }
  }

  Freedom freedomOf(std::int32_t v) const {
    std::vector<std::int32_t> ends;
    he_.forOutgoing(v, [&](std::int32_t h) {
      if (isFeature(h)) ends.push_back(he_.to(h));
    });
    if (ends.empty()) return Freedom::Surface;
    if (ends.size() != 2) return Freedom::None;
    // A curve that turns by more than 60° has a corner there
    const Vector3 u = (pos(v) - pos(ends[0])).normalized();
    const Vector3 w = (pos(ends[1]) - pos(v)).normalized();
    return u.dot(w) < 0.5 ? Freedom::None : Freedom::Curve;
  }

  Vector3 ontoPlaneOf(std::int32_t tag, const Vector3& p) const {
    const BoundaryTag what = unpacked(tag);
    return what.kind == BoundaryTag::Kind::CutPlane ? ontoPlane(cutPlanes_[toIndex(what.index)], p)
                                                    : p;
  }
  Vector3 ontoSurface(std::int32_t tag, const Vector3& p) const {
    return ontoPlaneOf(tag, trees_.at(tag).closest(p).point);
  }
  Vector3 ontoCurve(std::int32_t h, const Vector3& p) const {
    Vector3 q = curves_.closest(p).point;
    for (const std::int32_t side : {h, HalfEdges::opposite(h)}) q = ontoPlaneOf(he_.tag(side), q);
    return q;
  }

  // A triangle is good where its middle and the middles of its sides lie on the old surface of its
  // tag
  bool near(std::int32_t tag, const Vector3& a, const Vector3& b, const Vector3& c,
            double tolerance) const {
    const TriangleTree& tree = trees_.at(tag);
    return tree.within((a + b + c) / 3.0, tolerance) && tree.within(0.5 * (a + b), tolerance) &&
           tree.within(0.5 * (b + c), tolerance) && tree.within(0.5 * (c + a), tolerance);
  }

  /// May triangle (old → fresh) be replaced? Not if it would fold over, stray or become a needle.
  bool mayReplace(std::int32_t tag, const Vector3 (&was)[3], const Vector3 (&is)[3],
                  double tolerance) const {
    const double now = quality(is[0], is[1], is[2]);
    const double before = quality(was[0], was[1], was[2]);
    if (now < 0.1 && now < before) return false;
    const Vector3 n = (is[1] - is[0]).cross(is[2] - is[0]);
    Vector3 m = (was[1] - was[0]).cross(was[2] - was[0]);
    if (before < 0.05) {
      // Needles that corefinement leaves have no normal to speak of: ask the old surface
      const TriangleTree& tree = trees_.at(tag);
      m = tree.normal(tree.closest((is[0] + is[1] + is[2]) / 3.0).triangle);
    }
    if (n.dot(m) < 0.5 * n.norm() * m.norm()) return false;
    return near(tag, is[0], is[1], is[2], tolerance);
  }

  /// The faces around v, and the same with v at p, less the two that `collapsing` takes away.
  void fan(std::int32_t v, const Vector3& p, std::int32_t collapsing = -1) {
    before_.clear();
    after_.clear();
    he_.forOutgoing(v, [&](std::int32_t x) {
      before_.push_back(he_.face(x));
      if (collapsing >= 0 && (x == collapsing || he_.apex(x) == he_.to(collapsing))) return;
      const std::int32_t centre = collapsing >= 0 ? he_.to(collapsing) : v;
      const std::int32_t b = he_.to(x);
      const std::int32_t c = he_.apex(x);
      after_.push_back({he_.face(x), {{centre, b, c}, {p, pos(b), pos(c)}}});
    });
  }

  /// Takes the step from before_ to after_ unless it would lose points of the old surface or, where
  /// that is watched, make faces cross.
  bool take() {
    const SurfaceStep step{before_, after_};
    if (!samples_.allows(step)) return false;
    if (isWatched(step) && !watch_->allows(step)) return false;
    samples_.follow(step);
    if (watch_) watch_->follow(step);
    return true;
  }
  void takeAnyway() {
    const SurfaceStep step{before_, after_};
    samples_.followAnyway(step);
    if (watch_) watch_->follow(step);
  }
  bool isWatched(const SurfaceStep& step) const {
    return watch_ && std::ranges::any_of(step.after, [&](const NewFace& face) {
             return std::ranges::any_of(face.corners.vertex,
                                        [&](std::int32_t v) { return watched_[toIndex(v)] != 0; });
           });
  }
  bool takeAround(std::int32_t v, const Vector3& p) {
    fan(v, p);
    return take();
  }

  /// The edge to split instead of h: none of its two faces has a longer one [Rivara 1984]. In a
  /// needle, splitting a shorter side leaves sides as long as before, for ever.
  std::int32_t longestNear(std::int32_t h) const {
    for (;;) {
      std::int32_t longest = h;
      for (const std::int32_t side : {h, HalfEdges::opposite(h)}) {
        for (const std::int32_t x : {he_.next(side), he_.next(he_.next(side))}) {
          if (length(x) > length(longest)) longest = x;
        }
      }
      if (longest == h) return h;
      h = longest;
    }
  }

  void splitLong() {
    std::priority_queue<std::pair<double, std::int32_t>> queue;
    const auto look = [&](std::int32_t h) {
      if (length(h) > 4.0 / 3.0 * wanted(h)) queue.emplace(length(h), h);
    };
    for (std::int32_t h = 0; h < he_.halfEdgeCount(); h += 2) {
      if (he_.edgeAlive(h)) look(h);
    }
    while (!queue.empty()) {
      const auto [was, wish] = queue.top();
      if (length(wish) != was) {  // split since
        queue.pop();
        continue;
      }
      const std::int32_t h = longestNear(wish);
      const Vector3 middle = 0.5 * (pos(he_.from(h)) + pos(he_.to(h)));
      const bool curve = isFeature(h);
      const std::int32_t firstNew = he_.halfEdgeCount();
      const Vector3 p = projectedMiddle(h, middle);
      const auto [m, second] = he_.split(h);
      place(p);
      if (!takeAround(m, p)) {
        // Where projecting would lose a point of the old surface the two faces are only cut
        position_.back() = middle;
        fan(m, middle);
        takeAnyway();
      }
      freedom_.push_back(curve ? Freedom::Curve : Freedom::Surface);
      feature_.resize(toIndex(he_.halfEdgeCount() / 2), 0);
      feature_[toIndex(second / 2)] = curve;
      // Both halves, and the new spokes, may still be long
      for (const std::int32_t x : {h & ~1, firstNew, firstNew + 2, firstNew + 4}) look(x);
    }
  }

  // The middle of an edge, on the old surface where no triangle folds over by that
  Vector3 projectedMiddle(std::int32_t h, const Vector3& middle) const {
    const Vector3 p = isFeature(h) ? ontoCurve(h, middle) : ontoSurface(he_.tag(h), middle);
    if ((p - middle).norm() > 0.25 * length(h)) return middle;
    for (const std::int32_t side : {h, HalfEdges::opposite(h)}) {
      const Vector3& a = pos(he_.from(side));
      const Vector3& b = pos(he_.to(side));
      const Vector3& c = pos(he_.apex(side));
      const Vector3 n = (b - a).cross(c - a);
      if ((p - a).cross(c - a).dot(n) <= 0 || (b - p).cross(c - p).dot(n) <= 0) return middle;
    }
    return p;
  }

  void collapseShort() {
    std::vector<std::pair<double, std::int32_t>> queue;
    for (std::int32_t h = 0; h < he_.halfEdgeCount(); h += 2) {
      if (he_.edgeAlive(h) && length(h) < 0.8 * wanted(h))
        queue.emplace_back(length(h) / wanted(h), h);
    }
    std::ranges::sort(queue);
    for (const auto& [ratio, h] : queue) {
      if (!he_.edgeAlive(h) || length(h) >= 0.8 * wanted(h)) continue;
      if (!collapse(h)) collapse(HalfEdges::opposite(h));
    }
  }

  bool collapse(std::int32_t h) {
    if (!mayCollapse(h)) return false;
    fan(he_.from(h), pos(he_.to(h)), h);
    if (!take()) return false;
    merge(h);
    return true;
  }

  bool mayCollapse(std::int32_t h) const {
    const std::int32_t v = he_.from(h);
    const std::int32_t w = he_.to(h);
    if (freedom_[toIndex(v)] == Freedom::None) return false;
    if (freedom_[toIndex(v)] == Freedom::Curve && !isFeature(h)) return false;
    if (!he_.canCollapse(h)) return false;
    // Two curves must not become one
    const std::int32_t c = he_.next(he_.next(h));
    const std::int32_t d = he_.next(HalfEdges::opposite(h));
    if ((isFeature(c) && isFeature(he_.next(h))) || (isFeature(d) && isFeature(he_.next(d)))) {
      return false;
    }
    const double tolerance = std::min(tolerance_[toIndex(v)], tolerance_[toIndex(w)]);
    bool good = true;
    double nearest2 = std::numeric_limits<double>::infinity();
    he_.forOutgoing(v, [&](std::int32_t x) {
      if (!good) return;
      const std::int32_t u = he_.to(x);
      if (u != w && (pos(u) - pos(w)).norm() >
                        4.0 / 3.0 * std::min(wanted_[toIndex(u)], wanted_[toIndex(w)])) {
        good = false;
        return;
      }
      if (isFeature(x) && u != w) {
        // The curve that is left must stay near the curve that was
        for (const double s : {0.25, 0.5, 0.75}) {
          if (!curves_.within(pos(w) + s * (pos(u) - pos(w)), tolerance)) good = false;
        }
        if (!good) return;
      }
      if (x == h || he_.face(x) == he_.face(HalfEdges::opposite(h))) return;
      const Vector3& b = pos(u);
      const Vector3& a = pos(he_.apex(x));
      if (he_.apex(x) == w) return;  // the face of h itself, met from its other side
      good = mayReplace(he_.tag(x), {pos(v), b, a}, {pos(w), b, a}, tolerance);
      nearest2 =
          std::min(nearest2, (closestOnTriangle(pos(v), pos(w), b, a) - pos(v)).squaredNorm());
    });
    return good && nearest2 <= tolerance * tolerance;
  }

  void merge(std::int32_t h) {
    const std::int32_t n0 = he_.next(h);
    const std::int32_t p0 = he_.next(n0);
    const std::int32_t m0 = he_.next(HalfEdges::opposite(h));
    const std::int32_t q0 = he_.next(m0);
    feature_[toIndex(n0 / 2)] |= feature_[toIndex(p0 / 2)];
    feature_[toIndex(q0 / 2)] |= feature_[toIndex(m0 / 2)];
    he_.collapse(h);
  }

  // Flips that bring valences nearer to 6 without making worse triangles, or make bad triangles
  // much better
  void flipEdges() {
    for (std::int32_t h = 0; h < he_.halfEdgeCount(); h += 2) {
      if (!he_.edgeAlive(h) || isFeature(h)) continue;
      const std::int32_t o = HalfEdges::opposite(h);
      const std::int32_t a = he_.from(h), b = he_.to(h), c = he_.apex(h), d = he_.apex(o);
      const double before =
          std::min(quality(pos(a), pos(b), pos(c)), quality(pos(b), pos(a), pos(d)));
      const double after =
          std::min(quality(pos(d), pos(c), pos(a)), quality(pos(c), pos(d), pos(b)));
      const auto excess = [&](std::int32_t v, int change) {
        const int e = he_.valence(v) + change - 6;
        return e * e;
      };
      const int gain = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0) - excess(a, -1) -
                       excess(b, -1) - excess(c, 1) - excess(d, 1);
      const bool better =
          (gain > 0 && after > std::min(0.5, before)) || after > 1.2 * before + 0.02;
      if (!better || (gain < 0 && before > 0.6) || !he_.canFlip(h)) continue;
      const double tolerance = std::min({tolerance_[toIndex(a)], tolerance_[toIndex(b)],
                                         tolerance_[toIndex(c)], tolerance_[toIndex(d)]});
      if (!mayReplace(he_.tag(h), {pos(a), pos(b), pos(c)}, {pos(d), pos(c), pos(a)}, tolerance) ||
          !mayReplace(he_.tag(h), {pos(b), pos(a), pos(d)}, {pos(c), pos(d), pos(b)}, tolerance)) {
        continue;
      }
      before_ = {he_.face(h), he_.face(o)};
      after_ = {{he_.face(h), {{d, c, a}, {pos(d), pos(c), pos(a)}}},
                {he_.face(o), {{c, d, b}, {pos(c), pos(d), pos(b)}}}};
      if (take()) he_.flip(h);
    }
  }

  // Vertices to the weighted centre of their neighbours, on the surface or along the curve
  void relax() {
    for (std::int32_t v = 0; v < he_.vertexCount(); ++v) {
      if (!he_.vertexAlive(v) || freedom_[toIndex(v)] == Freedom::None) continue;
      const Vector3 p =
          freedom_[toIndex(v)] == Freedom::Curve ? relaxedOnCurve(v) : relaxedOnSurface(v);
      if (p == pos(v)) continue;
      bool good = true;
      he_.forOutgoing(v, [&](std::int32_t x) {
        const Vector3& b = pos(he_.to(x));
        const Vector3& a = pos(he_.apex(x));
        good = good && mayReplace(he_.tag(x), {pos(v), b, a}, {p, b, a}, tolerance_[toIndex(v)]);
        if (good && isFeature(x)) good = curves_.within(0.5 * (p + b), tolerance_[toIndex(v)]);
      });
      if (!good || !takeAround(v, p)) continue;
      position_[toIndex(v)] = p;
      wanted_[toIndex(v)] = options_.edgeLength(p);
      tolerance_[toIndex(v)] = options_.tolerance(p);
      watched_[toIndex(v)] = options_.watched && options_.watched(p);
    }
  }

  Vector3 relaxedOnSurface(std::int32_t v) const {
    Vector3 sum = Vector3::Zero();
    Vector3 n = Vector3::Zero();
    double weight = 0.0;
    he_.forOutgoing(v, [&](std::int32_t x) {
      const Vector3 m = normal(x);
      const Vector3 centre = (pos(v) + pos(he_.to(x)) + pos(he_.apex(x))) / 3.0;
      const double h = wanted_[toIndex(he_.to(x))];
      const double share = m.norm() / (h * h);
      sum += share * centre;
      weight += share;
      n += m;
    });
    if (weight == 0.0) return pos(v);
    Vector3 move = sum / weight - pos(v);
    if (n.squaredNorm() > 0) move -= n.dot(move) / n.squaredNorm() * n;
    return ontoSurface(he_.tag(he_.someOutgoing(v)), pos(v) + move);
  }

  Vector3 relaxedOnCurve(std::int32_t v) const {
    Vector3 sum = Vector3::Zero();
    std::int32_t some = -1;
    he_.forOutgoing(v, [&](std::int32_t x) {
      if (!isFeature(x)) return;
      sum += pos(he_.to(x));
      some = x;
    });
    return ontoCurve(some, 0.5 * (pos(v) + 0.5 * sum));
  }

  HalfEdges he_;
  const std::vector<CutPlane>& cutPlanes_;
  const ResampleOptions& options_;
  std::vector<Vector3> position_;
  std::vector<double> wanted_, tolerance_;
  std::vector<Freedom> freedom_;
  std::vector<std::uint8_t> watched_;  // per vertex
  std::vector<std::uint8_t> feature_;  // per edge
  std::map<std::int32_t, TriangleTree> trees_;
  TriangleTree curves_;
  CarriedSamples samples_;
  std::optional<CrossingWatch> watch_;
  std::vector<std::int32_t> before_;  // of the step that is being looked at
  std::vector<NewFace> after_;
};

}  // namespace

Result<TaggedSurface> resample(const TaggedSurface& surface, const std::vector<CutPlane>& cutPlanes,
                               const ResampleOptions& options, RunContext& run) {
  const Stage stage(run, "domain: resample");
  auto he = HalfEdges::build(surface);
  if (!he) return passOn(he);
  return Resampler(std::move(*he), surface, cutPlanes, options)(run);
}

}  // namespace ecorche::domain
