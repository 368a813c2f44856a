#include <ecorche/authoring/names.h>
#include <ecorche/authoring/seats.h>
#include <ecorche/core/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace ecorche::authoring {

using mesh::Vector3;
using model::Support;

namespace {

// Of the diagonal: how near a site must be to a bone to be on it, how far covers have to be off
constexpr double kReachRel = 0.03;
constexpr double kExposedRel = 5e-4;
constexpr double kSearchRel = 0.0015;  // first ring of the search; each next one is twice as wide
constexpr int kRings = 5;

bool isExposed(const Vector3& p, int bone, const FreeSpace& space, double diagonal) {
  return space.room(p, kExposedRel * diagonal, bone) >= kExposedRel * diagonal;
}

std::optional<Vector3> nearestExposed(const Vector3& p, int place, const BoneSurface& bone,
                                      const FreeSpace& space, double diagonal) {
  double radius = kSearchRel * diagonal;
  for (int ring = 0; ring < kRings; ++ring, radius *= 2.0) {
    std::optional<Vector3> best;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int z = -1; z <= 1; ++z) {
          if (x == 0 && y == 0 && z == 0) continue;
          const Vector3 q = bone.surface->closest(p + radius * Vector3(x, y, z).normalized()).point;
          if (best && (q - p).norm() >= (*best - p).norm()) continue;
          if (isExposed(q, place, space, diagonal)) best = q;
        }
      }
    }
    if (best) return best;
  }
  return std::nullopt;
}

}  // namespace

Seat seatOf(const AttachmentSite& site, const std::vector<BoneSurface>& bones,
            const FreeSpace& space, double diagonal) {
  const std::string wanted = bareName(site.bone);
  int place = -1;
  double nearest = kReachRel * diagonal;
  for (std::size_t b = 0; b < bones.size() && !wanted.empty(); ++b) {
    if (bareName(bones[b].name) == wanted && !bones[b].surface->empty() &&
        bones[b].surface->distance(site.at) <= nearest)
      place = static_cast<int>(b);
  }
  const bool named = place >= 0;
  for (std::size_t b = 0; b < bones.size() && !named; ++b) {
    if (bones[b].surface->empty() || bones[b].distanceToBox(site.at) > nearest) continue;
    const double distance = bones[b].surface->distance(site.at);
    if (distance > nearest) continue;
    nearest = distance;
    place = static_cast<int>(b);
  }
  if (place < 0) {
    const double least = kExposedRel * diagonal;
    return {site.at, {}, -1, space.room(site.at, least) >= least};
  }

  const BoneSurface& bone = bones[static_cast<std::size_t>(place)];
  Seat out{bone.surface->closest(site.at).point, {Support::On::Bone, bone.name}, place, true};
  if (isExposed(out.at, place, space, diagonal)) return out;
  if (const auto free = nearestExposed(out.at, place, bone, space, diagonal)) {
    out.at = *free;
  } else {
    out.exposed = false;
  }
  return out;
}

Seat seatOnPlane(const Vector3& p, const Mirror& plane, const std::string& name,
                 const FreeSpace& space, double diagonal) {
  Seat out{p - plane.height(p) * plane.normal, {Support::On::Plane, name}, -1, true};
  if (isExposed(out.at, -1, space, diagonal)) return out;
  Eigen::Index across = 0;
  plane.normal.cwiseAbs().minCoeff(&across);
  const Vector3 e1 = plane.normal.cross(Vector3::Unit(across)).normalized();
  const Vector3 e2 = plane.normal.cross(e1);
  double radius = kSearchRel * diagonal;
  for (int ring = 0; ring < 2 * kRings; ++ring, radius *= 1.5) {
    constexpr int kDirections = 16;
    for (int k = 0; k < kDirections; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kDirections;
      const Vector3 q = out.at + radius * (std::cos(angle) * e1 + std::sin(angle) * e2);
      if (isExposed(q, -1, space, diagonal)) return {q, out.support, -1, true};
    }
  }
  out.exposed = false;
  return out;
}

Seat slid(const Seat& seat, const Vector3& p, const std::vector<BoneSurface>& bones,
          const FreeSpace& space, double diagonal) {
  if (seat.bone < 0) return seat;
  Seat out = seat;
  out.at = bones[static_cast<std::size_t>(seat.bone)].surface->closest(p).point;
  const bool exposed = isExposed(out.at, seat.bone, space, diagonal);
  return exposed || !seat.exposed ? out : seat;
}

void spreadEnds(std::vector<SlidingEnd>& ends, const std::vector<BoneSurface>& bones,
                const FreeSpace& space, double diagonal) {
  constexpr int kRounds = 40;
  constexpr double kStep = 0.4;
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Seat> next(ends.size());
    parallelFor(
        std::ssize(ends),
        [&](std::int64_t k) {
          const SlidingEnd& end = ends[static_cast<std::size_t>(k)];
          next[static_cast<std::size_t>(k)] = *end.seat;
          if (end.seat->bone < 0) return;
          Vector3 push = Vector3::Zero();
          for (const SlidingEnd& other : ends) {
            if (other.muscle == end.muscle || other.seat->bone != end.seat->bone) continue;
            const double apart = std::min(end.apart, other.apart);
            const Vector3 gap = end.seat->at - other.seat->at;
            if (gap.norm() >= apart) continue;
            // At the very same place: each to a side of its own
            const Vector3 away = gap.norm() > 1e-9 * diagonal
                                     ? Vector3(gap.normalized())
                                     : Vector3(end.muscle < other.muscle ? 1 : -1, 0, 0);
            push += (apart - gap.norm()) * away;
          }
          const double height = (end.seat->at - end.planePoint).dot(end.planeNormal);
          if (!end.planeNormal.isZero() && height < 0.5 * end.apart)
            push += (0.5 * end.apart - height) * end.planeNormal;
          if (push.norm() > 0.02 * end.apart)
            next[static_cast<std::size_t>(k)] =
                slid(*end.seat, end.seat->at + kStep * push, bones, space, diagonal);
        },
        4);
    bool moved = false;
    for (std::size_t k = 0; k < ends.size(); ++k) {
      moved = moved || next[k].at != ends[k].seat->at;
      *ends[k].seat = next[k];
    }
    if (!moved) break;
  }
}

}  // namespace ecorche::authoring
