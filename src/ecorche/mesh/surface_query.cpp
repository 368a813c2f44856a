#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Simple_cartesian.h>
#include <ecorche/core/contract.h>
#include <ecorche/mesh/surface_query.h>

#include <Eigen/Geometry>
#include <cmath>

namespace ecorche::mesh {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Point = Kernel::Point_3;
using Triangle = Kernel::Triangle_3;
using TriangleList = std::vector<Triangle>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, TriangleList::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;
using Exact = CGAL::Exact_predicates_inexact_constructions_kernel;

Point toPoint(const Vector3& p) { return {p.x(), p.y(), p.z()}; }
Vector3 toVector(const Point& p) { return {p.x(), p.y(), p.z()}; }
Exact::Point_3 toExact(const Vector3& p) { return {p.x(), p.y(), p.z()}; }
Exact::Point_3 toExact(const Point& p) { return {p.x(), p.y(), p.z()}; }

// From p to q; boxes are missed only if they are missed with a margin for rounding.
struct Segment {
  Vector3 p;
  Vector3 q;
  double margin;

  [[nodiscard]] bool meets(const CGAL::Bbox_3& box, double sMax) const {
    double lo = 0.0;
    double hi = sMax;
    for (int k = 0; k < 3; ++k) {
      const double d = q[k] - p[k];
      const double below = box.min(k) - margin - p[k];
      const double above = box.max(k) + margin - p[k];
      if (d == 0.0) {
        if (below > 0 || above < 0) return false;
        continue;
      }
      const double a = below / d;
      const double b = above / d;
      lo = std::max(lo, std::min(a, b));
      hi = std::min(hi, std::max(a, b));
    }
    return lo <= hi * (1 + 1e-12) + 1e-15;
  }
};

// How the line from p to q passes a triangle, decided exactly.
struct Passage {
  bool through = false;  // through the triangle's inside or its border
  bool border = false;   // through the border, or within the plane
  int atP = 0;           // side of p: 1 where the normal points
  int atQ = 0;
};

Passage passage(const Segment& line, const Triangle& triangle) {
  const auto side = Exact().orientation_3_object();
  const auto p = toExact(line.p);
  const auto q = toExact(line.q);
  const auto a = toExact(triangle.vertex(0));
  const auto b = toExact(triangle.vertex(1));
  const auto c = toExact(triangle.vertex(2));
  const int ab = side(p, q, a, b);
  const int bc = side(p, q, b, c);
  if (ab * bc < 0) return {};
  const int ca = side(p, q, c, a);
  if (ab * ca < 0 || bc * ca < 0) return {};
  return {.through = true,
          .border = ab == 0 || bc == 0 || ca == 0,
          .atP = side(a, b, c, p),
          .atQ = side(a, b, c, q)};
}

Vector3 normalOf(const Triangle& t) {
  const Vector3 a = toVector(t.vertex(0));
  return (toVector(t.vertex(1)) - a).cross(toVector(t.vertex(2)) - a);
}

}  // namespace

struct SurfaceQuery::Impl {
  TriangleList triangles;
  std::vector<std::int32_t> face;  // of each triangle
  Tree tree;
  Box box;

  [[nodiscard]] std::size_t numberOf(const Primitive& primitive) const {
    return static_cast<std::size_t>(primitive.id() - triangles.cbegin());
  }
  [[nodiscard]] Segment segment(const Vector3& p, const Vector3& q) const {
    return {p, q, 1e-14 * (box.lo.cwiseAbs().maxCoeff() + box.hi.cwiseAbs().maxCoeff() + p.norm())};
  }
  // A factor that takes origin + factor·direction out of the box.
  [[nodiscard]] double reach(const Vector3& origin, const Vector3& direction) const {
    return 1.5 * ((origin - box.centre()).norm() + box.diagonal()) / direction.norm();
  }

  void collect(const Segment& line, double tOfQ, bool firstOnly, std::vector<Hit>& hits) const;
  [[nodiscard]] bool crossings(const Segment& line, int& winding, bool& onSurface) const;
};

namespace {

// The shape CGAL wants of something that walks down the tree.
template <class Meets, class Visit>
struct Walk {
  const Meets& meets;
  const Visit& visit;
  [[nodiscard]] bool go_further() const { return true; }
  void intersection(const Segment&, const Primitive& primitive) const { visit(primitive); }
  template <class Node>
  [[nodiscard]] bool do_intersect(const Segment&, const Node& node) const {
    return meets(node.bbox());
  }
};
template <class Meets, class Visit>
Walk(const Meets&, const Visit&) -> Walk<Meets, Visit>;

}  // namespace

SurfaceQuery::SurfaceQuery(const Positions& V, const Triangles& F)
    : impl_(std::make_unique<Impl>()) {
  impl_->triangles.reserve(static_cast<std::size_t>(F.rows()));
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    Vector3 p[3];
    for (int k = 0; k < 3; ++k) p[k] = V.row(F(f, k)).transpose();
    const Triangle triangle(toPoint(p[0]), toPoint(p[1]), toPoint(p[2]));
    if (triangle.is_degenerate()) continue;
    impl_->triangles.push_back(triangle);
    impl_->face.push_back(static_cast<std::int32_t>(f));
    for (const Vector3& x : p) impl_->box.add(x);
  }
  if (impl_->triangles.empty()) return;
  impl_->tree.insert(impl_->triangles.cbegin(), impl_->triangles.cend());
  // Both would otherwise be made by the first question, while others ask already
  impl_->tree.build();
  impl_->tree.accelerate_distance_queries();
}

SurfaceQuery::SurfaceQuery(SurfaceQuery&&) noexcept = default;
SurfaceQuery& SurfaceQuery::operator=(SurfaceQuery&&) noexcept = default;
SurfaceQuery::~SurfaceQuery() = default;

bool SurfaceQuery::empty() const { return impl_->triangles.empty(); }

SurfaceQuery::Closest SurfaceQuery::closest(const Vector3& p) const {
  EC_REQUIRE(!empty());
  const auto found = impl_->tree.closest_point_and_primitive(toPoint(p));
  const Vector3 point = toVector(found.first);
  const auto triangle = static_cast<std::size_t>(found.second - impl_->triangles.cbegin());
  return {point, impl_->face[triangle], (point - p).norm()};
}

double SurfaceQuery::signedDistance(const Vector3& p) const {
  const double d = distance(p);
  return inside(p) ? -d : d;
}

void SurfaceQuery::Impl::collect(const Segment& line, double tOfQ, bool firstOnly,
                                 std::vector<Hit>& hits) const {
  const Vector3 along = line.q - line.p;
  double nearest = 1.0;  // as a share of the segment
  const auto meets = [&](const CGAL::Bbox_3& b) { return line.meets(b, nearest); };
  const auto visit = [&](const Primitive& primitive) {
    const std::size_t n = numberOf(primitive);
    const Passage pass = passage(line, triangles[n]);
    if (!pass.through || pass.atP * pass.atQ > 0 || (pass.atP == 0 && pass.atQ == 0)) return;
    const Vector3 normal = normalOf(triangles[n]);
    const double slope = along.dot(normal);
    if (slope == 0.0) return;  // exactly not in the plane, but beyond what a division can tell
    const double s =
        std::clamp((toVector(triangles[n].vertex(0)) - line.p).dot(normal) / slope, 0.0, 1.0);
    const Hit hit{.t = s * tOfQ,
                  .face = face[n],
                  .point = line.p + s * along,
                  .entering = pass.atP >= pass.atQ};
    if (!firstOnly) {
      hits.push_back(hit);
    } else if (hits.empty() || hit.t < hits[0].t ||
               (hit.t == hits[0].t && hit.face < hits[0].face)) {
      hits.assign(1, hit);
      nearest = s;
    }
  };
  Walk walk{meets, visit};
  tree.traversal(line, walk);
}

std::vector<SurfaceQuery::Hit> SurfaceQuery::allHits(const Vector3& origin,
                                                     const Vector3& direction, double tMax) const {
  EC_REQUIRE(direction.norm() > 0.0);
  std::vector<Hit> hits;
  if (empty() || !(tMax >= 0.0)) return hits;
  const double t = std::min(tMax, impl_->reach(origin, direction));
  impl_->collect(impl_->segment(origin, origin + t * direction), t, false, hits);
  std::ranges::sort(
      hits, [](const Hit& a, const Hit& b) { return a.t != b.t ? a.t < b.t : a.face < b.face; });
  return hits;
}

std::optional<SurfaceQuery::Hit> SurfaceQuery::firstHit(const Vector3& origin,
                                                        const Vector3& direction,
                                                        double tMax) const {
  EC_REQUIRE(direction.norm() > 0.0);
  if (empty() || !(tMax >= 0.0)) return std::nullopt;
  std::vector<Hit> hits;
  const double t = std::min(tMax, impl_->reach(origin, direction));
  impl_->collect(impl_->segment(origin, origin + t * direction), t, true, hits);
  return hits.empty() ? std::nullopt : std::optional(hits[0]);
}

// False where the segment meets a border of a triangle: then its crossings cannot be counted.
bool SurfaceQuery::Impl::crossings(const Segment& line, int& winding, bool& onSurface) const {
  bool clear = true;
  winding = 0;
  onSurface = false;
  const auto meets = [&](const CGAL::Bbox_3& b) { return clear && line.meets(b, 1.0); };
  const auto visit = [&](const Primitive& primitive) {
    const Passage pass = passage(line, triangles[numberOf(primitive)]);
    if (!pass.through) return;
    if (pass.border) {
      clear = false;
    } else if (pass.atP == 0) {
      onSurface = true;
    } else if (pass.atP != pass.atQ) {
      winding -=
          pass.atP;  // behind the face before, in front of it after: we leave, so we were inside
    }
  };
  Walk walk{meets, visit};
  tree.traversal(line, walk);
  return clear;
}

std::optional<int> SurfaceQuery::windingNumber(const Vector3& p) const {
  if (empty() || (p.array() < impl_->box.lo.array()).any() ||
      (p.array() > impl_->box.hi.array()).any()) {
    return 0;
  }
  // Any direction will do unless it meets an edge; only from a point on an edge all of them do
  constexpr int kDirections = 12;
  for (int k = 0; k < kDirections; ++k) {
    const double turn = 2.399963229728653 * (k + 0.37);  // golden angle
    const double z = std::cos(2.718281828459045 * (k + 0.61));
    const double r = std::sqrt(1 - z * z);
    const Vector3 direction(r * std::cos(turn), r * std::sin(turn), z);
    int winding = 0;
    bool onSurface = false;
    const Segment line = impl_->segment(p, p + impl_->reach(p, direction) * direction);
    if (!impl_->crossings(line, winding, onSurface)) continue;
    return onSurface ? std::nullopt : std::optional(winding);
  }
  return std::nullopt;
}

bool SurfaceQuery::inside(const Vector3& p) const { return windingNumber(p).value_or(1) != 0; }

}  // namespace ecorche::mesh
