#include <ecorche/authoring/curve_relaxation.h>
#include <ecorche/authoring/stroke.h>
#include <ecorche/core/contract.h>
#include <ecorche/mesh/spline_fit.h>

#include <algorithm>

namespace ecorche::authoring {

using mesh::Vector3;

namespace {

constexpr int kFewPoints = 4;           // [ABLSJ21 §3.2]
constexpr double kKept = 0.5;           // of the clearance that a band asks for
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

}  // namespace

std::vector<Vector3> strokeInDepth(const std::vector<SightRay>& sights, const Vector3& from,
                                   const Vector3& to) {
  EC_REQUIRE(sights.size() >= 2);
  const double first = (from - sights.front().origin).dot(sights.front().direction);
  const double last = (to - sights.back().origin).dot(sights.back().direction);
  // Length of the stroke as the eye sees it: between points at one distance
  const double middle = 0.5 * (first + last);
  const auto at = [](const SightRay& ray, double depth) -> Vector3 {
    return ray.origin + depth * ray.direction;
  };
  std::vector<double> s{0.0};
  for (std::size_t i = 1; i < sights.size(); ++i)
    s.push_back(s.back() + (at(sights[i], middle) - at(sights[i - 1], middle)).norm());

  std::vector<Vector3> out;
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const double share = s.back() > 0.0 ? s[i] / s.back() : 1.0;
    out.push_back(at(sights[i], first + share * (last - first)));
  }
  out.front() = from;
  out.back() = to;
  return out;
}

std::vector<Vector3> fittedStroke(const std::vector<Vector3>& path) {
  return mesh::fitSpline(path, kFewPoints);
}

std::vector<Vector3> strokeCurve(const std::vector<Vector3>& path, const Surroundings& around) {
  const FreeSpace space(around.skin, around.bones);
  Band band = bandThrough(path.front(), waypoints(path), path.back(), around.diagonal);
  std::vector<Vector3> fitted = fittedStroke(path);
  if (isClear(fitted, band, space)) return fitted;
  band.guide = band.points;
  settle(band, space);
  return controlPoints(band, space);
}

}  // namespace ecorche::authoring
