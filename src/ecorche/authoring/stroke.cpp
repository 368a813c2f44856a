#include <ecorche/authoring/curve_relaxation.h>
#include <ecorche/authoring/stroke.h>
#include <ecorche/mesh/spline_fit.h>

#include <algorithm>
#include <array>
#include <limits>

namespace ecorche::authoring {

using mesh::Vector3;

namespace {

constexpr int kFewPoints = 4;  // [ABLSJ21 §3.2]
constexpr std::array<int, 4> kCounts = {kFewPoints, 5, 6, 8};
constexpr double kKept = 0.5;           // of the clearance that a band asks for
constexpr double kNarrow = 0.4;         // of the clearance, where there is no room for it
constexpr std::size_t kWaypoints = 24;  // of a stroke, for the band that is bent along it

// Whether a curve through these points keeps half the clearance that a bent one would.
bool isClear(const std::vector<Vector3>& points, const Band& band, const FreeSpace& space) {
  const mesh::Spline curve(points);
  const double length = curve.length();
  constexpr int kSamples = 48;
  for (int k = 1; k < kSamples; ++k) {
    const double s = length * k / kSamples;
    const double wanted =
        kKept * band.clearance * easeNearEnd(std::min(s, length - s), band.clearance);
    if (space.room(curve.at(curve.parameterAt(s)), 2.0 * band.clearance) < wanted) return false;
  }
  return true;
}

// So many points of a line, evenly, without its ends.
std::vector<Vector3> waypoints(const std::vector<Vector3>& path) {
  if (path.size() <= 2) return {};
  std::vector<Vector3> out;
  const std::size_t inner = path.size() - 2;
  const std::size_t count = std::min(inner, kWaypoints);
  for (std::size_t k = 0; k < count; ++k) out.push_back(path[1 + k * inner / count]);
  return out;
}

// The plane that comes nearest to a band: a band keeps to one.
void keepTo(const std::vector<model::CutPlane>& planes, Band& band) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const model::CutPlane& plane : planes) {
    for (const Vector3& p : band.points) {
      const double height = (p - plane.point).dot(plane.normal);
      if (height >= nearest) continue;
      nearest = height;
      band.planePoint = plane.point;
      band.planeNormal = plane.normal;
    }
  }
}

}  // namespace

std::vector<Vector3> fittedStroke(const std::vector<Vector3>& path) {
  return mesh::fitSpline(path, kFewPoints);
}

StrokeCurve strokeCurve(const std::vector<Vector3>& path, const StrokeRoom& room) {
  const FreeSpace space(room.skin, room.bones);
  Band band = bandThrough(path.front(), waypoints(path), path.back(), room.diagonal);
  std::optional<std::vector<Vector3>> tight;  // stays in the domain, but with little room
  for (const int count : kCounts) {
    const std::vector<Vector3> fitted = mesh::fitSpline(path, count);
    if (firstLeaving(mesh::Spline(fitted), room)) continue;
    if (isClear(fitted, band, space)) return {fitted, {}};
    if (!tight) tight = fitted;
  }

  keepTo(room.planes, band);
  band.guide = band.points;
  settle(band, space);
  StrokeCurve out{controlPoints(band, space), {}};
  out.leaving = firstLeaving(mesh::Spline(out.points), room);
  if (!out.leaving) return out;
  if (tight) return {std::move(*tight), {}};
  for (const auto& nearly : {out.points, fittedStroke(path)}) {
    if (auto cleared = clearedCurve(nearly, room)) return {std::move(*cleared), {}};
  }
  // A band that asks for less room, then one that forgets the stroke
  Band narrow = bandThrough(path.front(), waypoints(path), path.back(), room.diagonal);
  Band straight = bandThrough(path.front(), {}, path.back(), room.diagonal);
  narrow.clearance *= kNarrow;
  for (Band* each : {&narrow, &straight}) {
    keepTo(room.planes, *each);
    settle(*each, space);
    if (auto cleared = clearedCurve(controlPoints(*each, space), room))
      return {std::move(*cleared), {}};
  }
  return out;
}

}  // namespace ecorche::authoring
