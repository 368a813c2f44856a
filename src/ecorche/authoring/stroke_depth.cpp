#include <ecorche/authoring/stroke_depth.h>
#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ecorche::authoring {

using mesh::Vector3;

namespace {

constexpr std::size_t kSteps = 32;      // along the stroke
constexpr int kSide = 16;               // depths to either side of linear, first
constexpr double kReachOfLength = 0.4;  // how far these go
constexpr int kFiner = 4;               // times finer, then, around the best
constexpr int kRefinements = 2;
constexpr double kLeastBelly = 0.05;  // near ends, of the room that a belly wants in the middle
constexpr double kMostLack = 5.0;  // times the room wanted: what is deeper in bone counts as this

Vector3 pointOn(const SightRay& ray, double depth) { return ray.origin + depth * ray.direction; }

// Depths of both ends, and the way along the stroke as the eye sees it: between points at one
// distance [0, 1].
struct Ramp {
  double first = 0.0, last = 0.0;
  std::vector<double> share;

  Ramp(const std::vector<SightRay>& sights, const Vector3& from, const Vector3& to) {
    EC_REQUIRE(sights.size() >= 2);
    first = (from - sights.front().origin).dot(sights.front().direction);
    last = (to - sights.back().origin).dot(sights.back().direction);
    const double middle = 0.5 * (first + last);
    share.push_back(0.0);
    for (std::size_t i = 1; i < sights.size(); ++i)
      share.push_back(share.back() +
                      (pointOn(sights[i], middle) - pointOn(sights[i - 1], middle)).norm());
    const double whole = share.back();
    for (double& s : share) s = whole > 0.0 ? s / whole : 1.0;
  }
  [[nodiscard]] double depthAt(double s) const { return first + s * (last - first); }
};

// A line of sight and how deep flesh, skin and bones lie along it.
struct Station {
  SightRay sight;
  double share = 0.0;   // of the way, in [0, 1]
  double linear = 0.0;  // depth [m]
  double belly = 0.0;   // share of the room that the middle wants
  double under = 0.0;   // depth under the skin that it should have [m]
};

struct Crossing {
  double depth = 0.0;
  bool entering = false;
};

// Where a line of sight enters and leaves a surface within a stretch, with what lies before it; a
// line through an edge meets two faces there and crosses once.
std::vector<Crossing> crossingsOf(const mesh::SurfaceQuery& surface, const SightRay& sight,
                                  double same) {
  std::vector<Crossing> out;
  for (const auto& hit : surface.allHits(sight.origin, sight.direction)) {
    if (!out.empty() && out.back().entering == hit.entering && hit.t - out.back().depth <= same)
      continue;
    out.push_back({hit.t, hit.entering});
  }
  return out;
}

bool within(const std::vector<Crossing>& crossings, double depth) {
  int winding = 0;
  for (const Crossing& crossing : crossings) {
    if (crossing.depth > depth) break;
    winding += crossing.entering ? 1 : -1;
  }
  return winding > 0;
}

class DepthSearch {
 public:
  DepthSearch(std::vector<Station> stations, double length, const StrokeRoom& room,
              const DepthHabits& habits)
      : stations_(std::move(stations)), length_(length), room_(room), habits_(habits) {
    const double far = kReachOfLength * length_ + habits_.fromBone * length_;
    for (const BoneSurface& bone : room_.bones) {
      if (bone.surface->empty()) continue;
      const bool near = std::ranges::any_of(stations_, [&](const Station& s) {
        return bone.distanceToBox(pointOn(s.sight, s.linear)) <= far;
      });
      if (near) bones_.push_back(&bone);
    }
    skinHits_.resize(stations_.size());
    boneHits_.resize(stations_.size());
    parallelFor(
        std::ssize(stations_),
        [&](std::int64_t k) {
          const auto i = static_cast<std::size_t>(k);
          const double same = 1e-12 * room_.diagonal;
          if (room_.skin) skinHits_[i] = crossingsOf(*room_.skin, stations_[i].sight, same);
          for (const BoneSurface* bone : bones_)
            boneHits_[i].push_back(bone->solid ? crossingsOf(*bone->solid, stations_[i].sight, same)
                                               : std::vector<Crossing>());
        },
        1);
  }

  // Depths of least cost, less the linear ones.
  std::vector<double> solve() {
    // A change of depth by one step costs more than the mean of no change and two: small slopes
    // need small steps
    double step = kReachOfLength * length_ / kSide;
    std::vector<double> offset = best(std::vector<double>(stations_.size(), 0.0), step, kSide);
    for (int round = 0; round < kRefinements; ++round) {
      step /= kFiner;
      offset = best(offset, step, kFiner + kFiner / 2);
    }
    return offset;
  }

 private:
  std::vector<Station> stations_;
  double length_;
  const StrokeRoom& room_;
  const DepthHabits& habits_;
  std::vector<const BoneSurface*> bones_;
  std::vector<std::vector<Crossing>> skinHits_;               // by station
  std::vector<std::vector<std::vector<Crossing>>> boneHits_;  // by station and bone

  // What a place costs: how far it is from the depth under the skin that is expected, over the
  // length, and what room it lacks, over the room wanted
  [[nodiscard]] double costAt(std::size_t i, double depth) const {
    const Station& station = stations_[i];
    const Vector3 x = pointOn(station.sight, depth);
    const auto lackOf = [&](double distance, double wantedRel) {
      const double wanted = wantedRel * length_ * station.belly;
      if (!(wanted > 0.0)) return 0.0;
      const double lack = std::clamp(1.0 - distance / wanted, 0.0, kMostLack);
      return habits_.roomWeight * lack * lack;
    };
    double out = 0.0;
    if (room_.skin && !room_.skin->empty()) {
      double under = room_.skin->distance(x);
      if (!within(skinHits_[i], depth)) under = -under;
      const double off = (under - station.under) / length_;
      out += habits_.skinWeight * off * off + lackOf(under, habits_.fromSkin);
    }
    double toBone = habits_.fromBone * length_ * station.belly;
    for (std::size_t b = 0; b < bones_.size(); ++b) {
      const BoneSurface& bone = *bones_[b];
      const double toBox = bone.distanceToBox(x);
      if (toBox > 0.0 && toBox >= toBone) continue;
      const double d = (bone.solid ? *bone.solid : *bone.surface).distance(x);
      toBone = std::min(toBone, within(boneHits_[i][b], depth) ? -d : d);
    }
    out += lackOf(toBone, habits_.fromBone);
    for (const model::CutPlane& plane : room_.planes)
      out += lackOf((x - plane.point).dot(plane.normal), habits_.fromSkin);
    return out;
  }

  // Dynamic programming over so many steps to either side of a guess.
  std::vector<double> best(const std::vector<double>& around, double step, int side) const {
    const std::size_t last = stations_.size() - 1;
    const auto places = static_cast<std::size_t>(2 * side + 1);
    const double h = 1.0 / static_cast<double>(last);  // of the stroke
    const auto offsetAt = [&](std::size_t i, std::size_t k) {
      return around[i] + step * (static_cast<double>(k) - side);
    };
    std::vector<std::vector<double>> own(last + 1);
    parallelFor(
        static_cast<std::int64_t>(last) - 1,
        [&](std::int64_t j) {
          const auto i = static_cast<std::size_t>(j) + 1;
          for (std::size_t k = 0; k < places; ++k) {
            const double offset = offsetAt(i, k);
            // A string under this even pull hangs `lean` in the middle
            const double pull = 16.0 * habits_.lean * offset / length_;
            own[i].push_back(h * (costAt(i, stations_[i].linear + offset) + pull));
          }
        },
        1);
    own[0] = own[last] = {0.0};

    std::vector<std::vector<double>> cost(last + 1);
    std::vector<std::vector<std::size_t>> before(last + 1);
    cost[0] = {0.0};
    for (std::size_t i = 1; i <= last; ++i) {
      for (std::size_t k = 0; k < own[i].size(); ++k) {
        const double here = i == last ? 0.0 : offsetAt(i, k);
        double least = std::numeric_limits<double>::infinity();
        std::size_t from = 0;
        for (std::size_t j = 0; j < cost[i - 1].size(); ++j) {
          const double change = (here - (i == 1 ? 0.0 : offsetAt(i - 1, j))) / length_;
          const double sum = cost[i - 1][j] + change * change / h;
          if (sum >= least) continue;
          least = sum;
          from = j;
        }
        cost[i].push_back(least + own[i][k]);
        before[i].push_back(from);
      }
    }
    std::vector<double> out(last + 1, 0.0);
    std::size_t k = before[last][0];
    for (std::size_t i = last - 1; i > 0; --i) {
      out[i] = offsetAt(i, k);
      k = before[i][k];
    }
    return out;
  }
};

}  // namespace

std::vector<Vector3> strokeInDepth(const std::vector<SightRay>& sights, const Vector3& from,
                                   const Vector3& to) {
  const Ramp ramp(sights, from, to);
  std::vector<Vector3> out;
  for (std::size_t i = 0; i < sights.size(); ++i)
    out.push_back(pointOn(sights[i], ramp.depthAt(ramp.share[i])));
  out.front() = from;
  out.back() = to;
  return out;
}

std::vector<Vector3> strokeInFlesh(const std::vector<SightRay>& sights, const Vector3& from,
                                   const Vector3& to, const StrokeRoom& room,
                                   const DepthHabits& habits) {
  const std::vector<Vector3> path = strokeInDepth(sights, from, to);
  const Ramp ramp(sights, from, to);
  std::vector<double> s{0.0};
  for (std::size_t i = 1; i < path.size(); ++i)
    s.push_back(s.back() + (path[i] - path[i - 1]).norm());
  const double length = s.back();
  if (!(length > 0.0)) return {from, to};

  // Lines of sight at even steps along the linear path
  std::vector<Station> stations;
  std::size_t piece = 1;
  for (std::size_t k = 0; k <= kSteps; ++k) {
    const double share = static_cast<double>(k) / kSteps;
    const double at = share * length;
    while (piece + 1 < path.size() && s[piece] < at) ++piece;
    const double gap = s[piece] - s[piece - 1];
    const double t = gap > 0.0 ? std::clamp((at - s[piece - 1]) / gap, 0.0, 1.0) : 0.0;
    const auto between = [&](const auto& a, const auto& b) {
      return ((1.0 - t) * a + t * b).eval();
    };
    const SightRay& a = sights[piece - 1];
    const SightRay& b = sights[piece];
    Station station;
    station.sight = {between(a.origin, b.origin), between(a.direction, b.direction).normalized()};
    station.share = share;
    station.linear = ramp.depthAt((1.0 - t) * ramp.share[piece - 1] + t * ramp.share[piece]);
    station.belly = std::max(kLeastBelly, 4.0 * share * (1.0 - share));
    stations.push_back(station);
  }
  if (room.skin && !room.skin->empty()) {
    const double first = std::max(0.0, -room.skin->signedDistance(from));
    const double last = std::max(0.0, -room.skin->signedDistance(to));
    for (Station& station : stations)
      station.under = (1.0 - station.share) * first + station.share * last;
  }
  const std::vector<double> offset = DepthSearch(stations, length, room, habits).solve();
  std::vector<Vector3> out;
  for (std::size_t i = 0; i < stations.size(); ++i)
    out.push_back(pointOn(stations[i].sight, stations[i].linear + offset[i]));
  out.front() = from;
  out.back() = to;
  return out;
}

}  // namespace ecorche::authoring
