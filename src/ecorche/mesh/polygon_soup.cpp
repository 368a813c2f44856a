#include <ecorche/core/index.h>
#include <ecorche/mesh/polygon_soup.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace ecorche::mesh {

namespace {

using Corner = std::array<std::int32_t, 3>;
using Point2 = Eigen::Vector2d;

double cross(const Point2& a, const Point2& b, const Point2& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// Twice the polygon's vector area [Newell]; its direction is the normal of the plane that fits
// best.
Vector3 newell(const std::vector<Vector3>& polygon) {
  Vector3 n = Vector3::Zero();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Vector3 a = polygon[k] - polygon[0];
    const Vector3 b = polygon[(k + 1) % polygon.size()] - polygon[0];
    n += a.cross(b);
  }
  return n;
}

// Seen from the normal's side, counter-clockwise; empty where the polygon has no area.
std::vector<Point2> projected(const std::vector<Vector3>& polygon) {
  const Vector3 n = newell(polygon);
  const double length = n.norm();
  if (!(length > 0.0) || !std::isfinite(length)) return {};
  const Vector3 u = n.unitOrthogonal();
  const Vector3 w = (n / length).cross(u);
  std::vector<Point2> flat;
  flat.reserve(polygon.size());
  for (const Vector3& p : polygon) flat.emplace_back(u.dot(p - polygon[0]), w.dot(p - polygon[0]));
  return flat;
}

std::vector<Corner> fan(std::size_t n) {
  std::vector<Corner> triangles;
  for (std::size_t k = 1; k + 1 < n; ++k) {
    triangles.push_back({0, static_cast<std::int32_t>(k), static_cast<std::int32_t>(k + 1)});
  }
  return triangles;
}

std::vector<Corner> splitQuad(const std::vector<Vector3>& q) {
  const auto normal = [&](int a, int b, int c) { return (q[b] - q[a]).cross(q[c] - q[a]).eval(); };
  // Halves of a good cut face the same way
  const bool cut02 = normal(0, 1, 2).dot(normal(0, 2, 3)) > 0;
  const bool cut13 = normal(1, 2, 3).dot(normal(1, 3, 0)) > 0;
  const bool shorter02 = (q[2] - q[0]).squaredNorm() <= (q[3] - q[1]).squaredNorm();
  if (cut02 != cut13 ? cut02 : shorter02) return {{0, 1, 2}, {0, 2, 3}};
  return {{1, 2, 3}, {1, 3, 0}};
}

// Ear clipping on a ring of corners [Meisters 1975]. Only corners that are not convex can lie in an
// ear.
class EarClipper {
 public:
  explicit EarClipper(std::vector<Point2> flat)
      : p_(std::move(flat)), next_(p_.size()), previous_(p_.size()), gone_(p_.size(), 0) {
    const auto n = static_cast<std::int32_t>(p_.size());
    for (std::int32_t k = 0; k < n; ++k) {
      next_[toIndex(k)] = (k + 1) % n;
      previous_[toIndex(k)] = (k + n - 1) % n;
    }
    double extent = 0.0;
    for (const Point2& q : p_) extent = std::max(extent, (q - p_[0]).squaredNorm());
    straight_ = 1e-12 * extent;
    for (std::int32_t k = 0; k < n; ++k) {
      if (!(turn(k) > straight_)) blunt_.push_back(k);
    }
  }

  std::vector<Corner> clip() {
    std::vector<Corner> triangles;
    triangles.reserve(p_.size() - 2);
    std::int32_t at = 0;
    std::int32_t left = static_cast<std::int32_t>(p_.size());
    std::int32_t refused = 0;  // corners looked at since the last ear
    while (left > 3) {
      // A straight corner makes a triangle without area: only when nothing better is left. Where
      // the polygon crosses itself there may be no ear at all, and any corner has to do.
      const bool ear = (refused < left && turn(at) > straight_ && isEmpty(at, -straight_)) ||
                       (refused >= left && turn(at) >= 0 && isEmpty(at, 0.0)) ||
                       refused >= 2 * left || budget_ <= 0;
      if (!ear) {
        ++refused;
        at = next_[toIndex(at)];
        continue;
      }
      const std::int32_t before = previous_[toIndex(at)];
      const std::int32_t after = next_[toIndex(at)];
      triangles.push_back({before, at, after});
      next_[toIndex(before)] = after;
      previous_[toIndex(after)] = before;
      gone_[toIndex(at)] = 1;
      at = next_[toIndex(after)];  // skipping one makes rounder triangles than a fan
      --left;
      refused = 0;
    }
    triangles.push_back({previous_[toIndex(at)], at, next_[toIndex(at)]});
    return triangles;
  }

 private:
  double turn(std::int32_t k) const {
    return cross(p_[toIndex(previous_[toIndex(k)])], p_[toIndex(k)],
                 p_[toIndex(next_[toIndex(k)])]);
  }

  // No other corner in the triangle at k. Corners at the place of the triangle's own (a keyhole's
  // seam) are let be.
  bool isEmpty(std::int32_t k, double margin) {
    const Point2& a = p_[toIndex(previous_[toIndex(k)])];
    const Point2& b = p_[toIndex(k)];
    const Point2& c = p_[toIndex(next_[toIndex(k)])];
    for (std::size_t r = 0; r < blunt_.size();) {
      const std::int32_t q = blunt_[r];
      --budget_;
      // Corners turn convex as their neighbours go; they leave the list when they are met
      if (gone_[toIndex(q)] || turn(q) > straight_) {
        blunt_[r] = blunt_.back();
        blunt_.pop_back();
        continue;
      }
      ++r;
      const Point2& x = p_[toIndex(q)];
      if (x == a || x == b || x == c) continue;
      if (cross(a, b, x) >= margin && cross(b, c, x) >= margin && cross(c, a, x) >= margin) {
        return false;
      }
    }
    return true;
  }

  std::vector<Point2> p_;
  std::vector<std::int32_t> next_;
  std::vector<std::int32_t> previous_;
  std::vector<char> gone_;
  double straight_ = 0.0;            // twice the area of a corner that rounding alone may have bent
  std::vector<std::int32_t> blunt_;  // corners that are not convex, and some that have become so
  std::int64_t budget_ = 100'000'000;  // point-in-triangle tests: about a second
};

}  // namespace

std::vector<Corner> triangulatePolygon(const std::vector<Vector3>& polygon) {
  if (polygon.size() < 3) return {};
  if (polygon.size() == 3) return {{0, 1, 2}};
  if (polygon.size() == 4) return splitQuad(polygon);
  std::vector<Point2> flat = projected(polygon);
  if (flat.empty()) return fan(polygon.size());
  return EarClipper(std::move(flat)).clip();
}

SurfaceMesh triangulated(const PolygonSoup& soup) {
  SurfaceMesh mesh;
  mesh.V = Eigen::Map<const Positions>(soup.xyz.data(), soup.vertexCount(), 3);

  // Where each polygon starts, and the order that puts the faces of a part together
  const std::size_t count = soup.size.size();
  std::vector<std::size_t> first(count + 1, 0);
  for (std::size_t p = 0; p < count; ++p)
    first[p + 1] = first[p] + static_cast<std::size_t>(soup.size[p]);
  std::vector<std::int32_t> order(count);
  std::iota(order.begin(), order.end(), 0);
  if (!soup.part.empty()) {
    std::vector<std::int32_t> rank(soup.partNames.size(), -1);
    std::int32_t seen = 0;
    for (const std::int32_t part : soup.part) {
      auto& r = rank[static_cast<std::size_t>(part)];
      if (r < 0) r = seen++;
    }
    const auto rankOf = [&](std::int32_t p) {
      return rank[static_cast<std::size_t>(soup.part[static_cast<std::size_t>(p)])];
    };
    if (!std::ranges::is_sorted(order, {}, rankOf)) std::ranges::stable_sort(order, {}, rankOf);
  }

  mesh.F.resize(static_cast<Eigen::Index>(soup.corners.size() - 2 * count), 3);
  std::vector<Vector3> polygon;
  Eigen::Index f = 0;
  std::int32_t last = -1;  // part
  for (const std::int32_t p : order) {
    const std::int32_t* corner = soup.corners.data() + first[static_cast<std::size_t>(p)];
    const std::int32_t n = soup.size[static_cast<std::size_t>(p)];
    if (!soup.part.empty()) {
      const std::int32_t part = soup.part[static_cast<std::size_t>(p)];
      if (part != last) {
        mesh.parts.push_back(
            {soup.partNames[static_cast<std::size_t>(part)], static_cast<std::int32_t>(f), 0});
      }
      last = part;
      mesh.parts.back().faceCount += n - 2;
    }
    if (n == 3) {
      mesh.F.row(f++) << corner[0], corner[1], corner[2];
      continue;
    }
    polygon.clear();
    for (std::int32_t k = 0; k < n; ++k) polygon.push_back(mesh.V.row(corner[k]).transpose());
    for (const auto& t : triangulatePolygon(polygon)) {
      mesh.F.row(f++) << corner[t[0]], corner[t[1]], corner[t[2]];
    }
  }
  return mesh;
}

}  // namespace ecorche::mesh
