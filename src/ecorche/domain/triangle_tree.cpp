#include <ecorche/domain/triangle_tree.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace ecorche::domain {

using mesh::Vector3;

namespace {

constexpr std::int32_t kLeafSize = 4;

Vector3 closestOnSegment(const Vector3& p, const Vector3& a, const Vector3& b) {
  const Vector3 ab = b - a;
  const double length2 = ab.squaredNorm();
  if (length2 == 0.0) return a;
  return a + std::clamp(ab.dot(p - a) / length2, 0.0, 1.0) * ab;
}

double boxDistance2(const Eigen::Array3d& lo, const Eigen::Array3d& hi, const Vector3& p) {
  return (lo - p.array()).max(p.array() - hi).max(0.0).matrix().squaredNorm();
}

}  // namespace

Vector3 closestOnTriangle(const Vector3& p, const Vector3& a, const Vector3& b, const Vector3& c) {
  const Vector3 ab = b - a;
  const Vector3 ac = c - a;
  if (ab.cross(ac).squaredNorm() <= 1e-28 * ab.squaredNorm() * ac.squaredNorm()) {
    // No area: the nearest of the three sides
    Vector3 best = closestOnSegment(p, a, b);
    for (const Vector3& q : {closestOnSegment(p, b, c), closestOnSegment(p, c, a)}) {
      if ((q - p).squaredNorm() < (best - p).squaredNorm()) best = q;
    }
    return best;
  }
  const Vector3 ap = p - a;
  const double d1 = ab.dot(ap);
  const double d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return a;
  const Vector3 bp = p - b;
  const double d3 = ab.dot(bp);
  const double d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return b;
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return a + d1 / (d1 - d3) * ab;
  const Vector3 cp = p - c;
  const double d5 = ab.dot(cp);
  const double d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return c;
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return a + d2 / (d2 - d6) * ac;
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 >= d3 && d5 >= d6) return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  const double scale = 1.0 / (va + vb + vc);
  return a + vb * scale * ab + vc * scale * ac;
}

TriangleTree::TriangleTree(const mesh::Positions& V, const mesh::Triangles& F) {
  if (F.rows() == 0) return;
  triangles_.reserve(static_cast<std::size_t>(F.rows()));
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    triangles_.push_back({V.row(F(f, 0)).transpose(), V.row(F(f, 1)).transpose(),
                          V.row(F(f, 2)).transpose(), static_cast<std::int32_t>(f)});
  }
  nodes_.reserve(triangles_.size());
  nodes_.emplace_back();
  build(0, 0, static_cast<std::int32_t>(triangles_.size()));
  slotOfRow_.resize(triangles_.size());
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    slotOfRow_[static_cast<std::size_t>(triangles_[i].row)] = static_cast<std::int32_t>(i);
  }
}

void TriangleTree::build(std::int32_t node, std::int32_t begin, std::int32_t end) {
  const auto first = triangles_.begin() + begin;
  const auto last = triangles_.begin() + end;
  Eigen::Array3d lo = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array3d hi = -lo;
  Eigen::Array3d centreLo = lo;
  Eigen::Array3d centreHi = hi;
  for (auto t = first; t != last; ++t) {
    for (const Vector3* p : {&t->a, &t->b, &t->c}) {
      lo = lo.min(p->array());
      hi = hi.max(p->array());
    }
    const Eigen::Array3d centre = (t->a + t->b + t->c).array();
    centreLo = centreLo.min(centre);
    centreHi = centreHi.max(centre);
  }
  nodes_[static_cast<std::size_t>(node)].lo = lo;
  nodes_[static_cast<std::size_t>(node)].hi = hi;
  if (end - begin <= kLeafSize) {
    nodes_[static_cast<std::size_t>(node)].first = begin;
    nodes_[static_cast<std::size_t>(node)].count = end - begin;
    return;
  }
  // Halved at the median centre along the longest side; ties by row, so that the tree is the same
  // everywhere
  int axis = 0;
  (centreHi - centreLo).maxCoeff(&axis);
  const std::int32_t middle = (begin + end) / 2;
  std::nth_element(first, triangles_.begin() + middle, last,
                   [axis](const Triangle& s, const Triangle& t) {
                     const double x = s.a[axis] + s.b[axis] + s.c[axis];
                     const double y = t.a[axis] + t.b[axis] + t.c[axis];
                     return x != y ? x < y : s.row < t.row;
                   });
  const auto child = static_cast<std::int32_t>(nodes_.size());
  nodes_.emplace_back();
  nodes_.emplace_back();
  nodes_[static_cast<std::size_t>(node)].first = child;
  build(child, begin, middle);
  build(child + 1, middle, end);
}

TriangleTree::Closest TriangleTree::closest(const Vector3& p, double limit2) const {
  Closest best;
  best.distance2 = limit2;
  if (empty()) return best;
  std::array<std::pair<std::int32_t, double>, 64> stack;
  std::size_t top = 0;
  stack[top++] = {0, boxDistance2(nodes_[0].lo, nodes_[0].hi, p)};
  while (top > 0) {
    const auto [index, distance2] = stack[--top];
    if (distance2 >= best.distance2) continue;
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (node.count > 0) {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        const Triangle& t = triangles_[static_cast<std::size_t>(i)];
        const Vector3 q = closestOnTriangle(p, t.a, t.b, t.c);
        const double d2 = (q - p).squaredNorm();
        if (d2 < best.distance2) best = {q, d2, t.row};
      }
      continue;
    }
    const auto at = [&](std::int32_t child) {
      const Node& n = nodes_[static_cast<std::size_t>(child)];
      return std::pair{child, boxDistance2(n.lo, n.hi, p)};
    };
    auto near = at(node.first);
    auto far = at(node.first + 1);
    if (far.second < near.second) std::swap(near, far);
    stack[top++] = far;
    stack[top++] = near;
  }
  return best;
}

template <class Wanted, class Done>
bool TriangleTree::visit(const Wanted& wanted, const Done& done) const {
  std::array<std::int32_t, 64> stack;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[--top])];
    if (!wanted(node)) continue;
    if (node.count == 0) {
      stack[top++] = node.first + 1;
      stack[top++] = node.first;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      if (done(triangles_[static_cast<std::size_t>(i)])) return true;
    }
  }
  return false;
}

bool TriangleTree::within(const Vector3& p, double r) const {
  if (empty()) return false;
  const double r2 = r * r;
  return visit([&](const Node& node) { return boxDistance2(node.lo, node.hi, p) <= r2; },
               [&](const Triangle& t) {
                 return (closestOnTriangle(p, t.a, t.b, t.c) - p).squaredNorm() <= r2;
               });
}

std::optional<double> TriangleTree::firstHit(const Vector3& origin, const Vector3& direction,
                                             double tMin, double tMax) const {
  if (empty()) return std::nullopt;
  // A zero component would make 0 · ∞ on the sides of boxes
  const Eigen::Array3d inverse = (direction.array() == 0.0)
                                     .select(Eigen::Array3d::Constant(1e-30), direction.array())
                                     .inverse();
  double best = tMax;
  bool found = false;
  visit(
      [&](const Node& node) {
        const Eigen::Array3d t0 = (node.lo - origin.array()) * inverse;
        const Eigen::Array3d t1 = (node.hi - origin.array()) * inverse;
        return t0.min(t1).maxCoeff() <= best && t0.max(t1).minCoeff() >= tMin;
      },
      [&](const Triangle& t) {
        // [Möller & Trumbore 1997]
        const Vector3 e1 = t.b - t.a;
        const Vector3 e2 = t.c - t.a;
        const Vector3 h = direction.cross(e2);
        const double det = e1.dot(h);
        if (det == 0.0) return false;
        const Vector3 s = origin - t.a;
        const double u = s.dot(h) / det;
        if (u < 0.0 || u > 1.0) return false;
        const Vector3 q = s.cross(e1);
        const double v = direction.dot(q) / det;
        if (v < 0.0 || u + v > 1.0) return false;
        const double hit = e2.dot(q) / det;
        if (hit > tMin && hit < best) {
          best = hit;
          found = true;
        }
        return false;
      });
  if (!found) return std::nullopt;
  return best;
}

Vector3 TriangleTree::normal(std::int32_t triangle) const {
  const Triangle& t =
      triangles_[static_cast<std::size_t>(slotOfRow_[static_cast<std::size_t>(triangle)])];
  return (t.b - t.a).cross(t.c - t.a);
}

}  // namespace ecorche::domain
