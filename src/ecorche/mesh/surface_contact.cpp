#include <ecorche/mesh/surface_contact.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace ecorche::mesh {

namespace {

constexpr double kCells = 14.0 * 14.0 * 14.0;  // of a lattice

Box shared(const Box& a, const Box& b) { return {a.lo.cwiseMax(b.lo), a.hi.cwiseMin(b.hi)}; }

bool within(const Box& box, const Vector3& p) {
  return (box.lo.array() <= p.array()).all() && (box.hi.array() >= p.array()).all();
}

/// Volume of the points of a box for which something holds, on a lattice of cubes.
template <class Holds>
double latticeVolume(const Box& box, const Holds& holds) {
  const Vector3 size = box.hi - box.lo;
  if (!(size.minCoeff() > 0.0)) return 0.0;
  const double edge = std::cbrt(size.prod() / kCells);
  Eigen::Array3i count;
  for (int k = 0; k < 3; ++k) count[k] = static_cast<int>(std::clamp(size[k] / edge, 4.0, 200.0));
  const Vector3 cell = size.cwiseQuotient(count.cast<double>().matrix());
  std::int64_t inside = 0;
  for (int x = 0; x < count[0]; ++x) {
    for (int y = 0; y < count[1]; ++y) {
      for (int z = 0; z < count[2]; ++z)
        inside += holds(box.lo + Vector3(x + 0.5, y + 0.5, z + 0.5).cwiseProduct(cell));
    }
  }
  return static_cast<double>(inside) * cell.prod();
}

/// The vertex of a that lies deepest in b, how many do, and how near the others come.
struct Reach {
  double deepest = 0.0;
  Vector3 deepPlace = Vector3::Zero();
  double nearest = std::numeric_limits<double>::infinity();
  Vector3 nearPlace = Vector3::Zero();
  std::int64_t inside = 0;
  std::int64_t vertices = 0;
};

Reach reachOf(const ContactBody& a, const ContactBody& b, double tolerance) {
  Box room = b.box;
  room.lo.array() -= tolerance;
  room.hi.array() += tolerance;
  Reach out;
  std::vector<char> seen(static_cast<std::size_t>(a.mesh.V.rows()), 0);
  for (const std::int32_t v : a.mesh.F.reshaped()) {
    if (std::exchange(seen[static_cast<std::size_t>(v)], 1) != 0) continue;
    ++out.vertices;
    const Vector3 p = a.mesh.V.row(v).transpose();
    if (!within(room, p)) continue;
    const double distance = b.query.distance(p);
    if (distance < out.nearest) {
      out.nearest = distance;
      out.nearPlace = p;
    }
    if (!within(b.box, p) || b.query.windingNumber(p).value_or(0) == 0) continue;
    ++out.inside;
    if (distance <= out.deepest) continue;
    out.deepest = distance;
    out.deepPlace = p;
  }
  return out;
}

}  // namespace

std::optional<SurfaceContact> contactOf(const ContactBody& a, const ContactBody& b,
                                        double tolerance) {
  if (a.query.empty() || b.query.empty()) return std::nullopt;
  const Box both = shared(a.box, b.box);
  if (((both.lo - both.hi).array() > tolerance).any()) return std::nullopt;
  const Reach ab = reachOf(a, b, tolerance);
  const Reach ba = reachOf(b, a, tolerance);
  SurfaceContact out;
  const bool first = ab.deepest >= ba.deepest;
  out.depth = std::max(ab.deepest, ba.deepest);
  out.place = first ? ab.deepPlace : ba.deepPlace;
  out.volume = latticeVolume(both, [&](const Vector3& p) {
    return a.query.windingNumber(p).value_or(0) != 0 && b.query.windingNumber(p).value_or(0) != 0;
  });
  if (out.depth > 0.0 || out.volume > 0.0) {
    out.kind = ab.inside == ab.vertices && ab.vertices > 0 ? SurfaceContact::Kind::Within
                                                           : SurfaceContact::Kind::Overlap;
    // Edges that cross without a vertex inside have a volume but no depth
    if (out.depth == 0.0) out.place = both.centre();
    return out;
  }
  out.depth = std::min(ab.nearest, ba.nearest);
  out.place = ab.nearest <= ba.nearest ? ab.nearPlace : ba.nearPlace;
  if (out.depth > tolerance) return std::nullopt;
  return out;
}

std::optional<PokingOut> pokingOut(const ContactBody& body, const ContactBody& skin,
                                   const std::function<bool(const Vector3&)>& counts) {
  if (body.query.empty() || skin.query.empty()) return std::nullopt;
  PokingOut out;
  bool any = false;
  for (const std::int32_t v : body.mesh.F.reshaped()) {
    const Vector3 p = body.mesh.V.row(v).transpose();
    if (counts && !counts(p)) continue;
    if (within(skin.box, p) && skin.query.windingNumber(p).value_or(1) != 0) continue;
    any = true;
    const double distance = skin.query.distance(p);
    if (distance < out.depth) continue;
    out.depth = distance;
    out.place = p;
  }
  if (!any) return std::nullopt;
  out.volume = latticeVolume(body.box, [&](const Vector3& p) {
    return (!counts || counts(p)) && body.query.windingNumber(p).value_or(0) != 0 &&
           skin.query.windingNumber(p).value_or(0) == 0;
  });
  return out;
}

}  // namespace ecorche::mesh
