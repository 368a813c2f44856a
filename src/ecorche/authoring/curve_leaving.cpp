#include <ecorche/authoring/curve_leaving.h>
#include <ecorche/authoring/free_space.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace ecorche::authoring {

using mesh::Vector3;

namespace {

constexpr double kChordRel = 5e-4;  // of the diagonal: chords, and what counts as an end
constexpr double kLift = 3.0;       // chords that a lifted tip is long
constexpr double kClear = 2.0;      // chords of room that a place wants that the curve is drawn to

// A place off an end with room around it, towards the next control point where there is a choice.
Vector3 liftedFrom(const Vector3& end, const Vector3& next, const FreeSpace& space, double length) {
  const Vector3 towards = (next - end).normalized();
  Vector3 best = end + length * towards;
  double most = -1.0;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Vector3 off(x, y, z);
        const Vector3 way = off.isZero() ? towards : Vector3(off.normalized());
        const Vector3 place = end + length * way;
        const double score = space.room(place, length) / length + 0.5 * way.dot(towards);
        if (score <= most) continue;
        most = score;
        best = place;
      }
    }
  }
  return best;
}

// Where the curve is deepest behind a wall that it goes through at a point.
std::pair<double, Vector3> deepestFrom(const mesh::Spline& curve, const Vector3& wall,
                                       const FreeSpace& space, double step) {
  const double begin = curve.nearest(wall);
  const double from = curve.lengthTo(begin);
  std::pair<double, Vector3> best{begin, curve.at(begin)};
  double least = std::numeric_limits<double>::infinity();
  constexpr int kSteps = 200;
  for (int k = 0; k < kSteps && from + k * step < curve.length(); ++k) {
    const double u = curve.parameterAt(from + k * step);
    const Vector3 p = curve.at(u);
    const double room = space.room(p, 4.0 * step);
    if (room < least) {
      least = room;
      best = {u, p};
    }
    if (k > 1 && room > step) break;
  }
  return best;
}

}  // namespace

std::optional<Leaving> firstLeaving(const mesh::Spline& curve, const StrokeRoom& room) {
  const double step = kChordRel * room.diagonal;
  const std::vector<Vector3> points = curve.sample(step).point;
  const Vector3& from = points.front();
  const Vector3& to = points.back();
  const auto atEnd = [&](const Vector3& p) {
    return (p - from).norm() <= step || (p - to).norm() <= step;
  };

  // Between the ends the curve is inside if one place is and nothing is crossed
  const auto middle = std::ranges::find_if_not(points, atEnd);
  if (middle != points.end()) {
    if (room.skin && !room.skin->inside(*middle))
      return Leaving{Leaving::Through::Skin, {}, *middle};
    for (const BoneSurface& bone : room.bones) {
      if (bone.solid == bone.surface && bone.distanceToBox(*middle) == 0.0 &&
          bone.surface->inside(*middle))
        return Leaving{Leaving::Through::Bone, bone.name, *middle};
    }
  }
  for (std::size_t i = 1; i < points.size(); ++i) {
    const Vector3& p = points[i - 1];
    const Vector3 along = points[i] - p;
    const double length = along.norm();
    if (!(length > 0.0)) continue;
    const auto meets = [&](const mesh::SurfaceQuery& surface) -> std::optional<Vector3> {
      for (const auto& hit : surface.allHits(p, along, 1.0)) {
        if (!atEnd(hit.point)) return hit.point;
      }
      return std::nullopt;
    };
    if (room.skin) {
      if (const auto at = meets(*room.skin)) return Leaving{Leaving::Through::Skin, {}, *at};
    }
    for (const BoneSurface& bone : room.bones) {
      if (bone.surface->empty() || bone.distanceToBox(p) > length) continue;
      if (const auto at = meets(*bone.surface))
        return Leaving{Leaving::Through::Bone, bone.name, *at};
    }
    for (const model::CutPlane& plane : room.planes) {
      if ((points[i] - plane.point).dot(plane.normal) < 0.0 && !atEnd(points[i]))
        return Leaving{Leaving::Through::Plane, plane.name, points[i]};
    }
  }
  return std::nullopt;
}

std::optional<std::vector<Vector3>> clearedCurve(const std::vector<Vector3>& points,
                                                 const StrokeRoom& room, std::size_t most) {
  const FreeSpace space(room.skin, room.bones);
  const double step = kChordRel * room.diagonal;
  const double lift = std::min(kLift * step, 0.1 * mesh::Spline(points).length());
  std::vector<Vector3> out = points;
  out.insert(out.begin() + 1, liftedFrom(out[0], out[1], space, lift));
  out.insert(out.end() - 1, liftedFrom(out.back(), out[out.size() - 2], space, lift));
  constexpr int kRounds = 40;
  int rounds = 0;
  while (out.size() < most) {
    const mesh::Spline curve(out);
    const auto leaving = firstLeaving(curve, room);
    if (!leaving) return out;

    // The deepest place of the stretch behind the wall, once that is pushed to where there is room
    const auto [u, deepest] = deepestFrom(curve, leaving->at, space, step);
    Vector3 place = deepest;
    constexpr int kPushes = 12;
    for (int k = 0; k < kPushes; ++k) {
      const FreeSpace::Push push = space.push(place, kClear * step, 4.0 * kClear * step);
      if (push.step.norm() < 0.05 * step) break;
      place += push.step;
    }
    for (const model::CutPlane& plane : room.planes) {
      const double height = (place - plane.point).dot(plane.normal);
      if (height < step) place += (step - height) * plane.normal;
    }

    // Two control points beside one another would make a knot: then the one that is there moves
    const auto before =
        static_cast<std::size_t>(std::clamp(std::floor(u), 0.0, curve.lastParameter() - 1.0));
    std::size_t beside = 0;
    for (const std::size_t k : {before, before + 1}) {
      if (k > 0 && k + 1 < out.size() && (out[k] - deepest).norm() < 2.0 * step) beside = k;
    }
    if (beside == 0) {
      out.insert(out.begin() + static_cast<std::ptrdiff_t>(before) + 1, place);
    } else if ((out[beside] - place).norm() > 0.05 * step) {
      out[beside] = place;
    } else {
      return std::nullopt;
    }
    for (std::size_t k = 1; k < out.size(); ++k) {
      if ((out[k] - out[k - 1]).norm() < 0.05 * step) return std::nullopt;
    }
    if (++rounds == kRounds) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace ecorche::authoring
