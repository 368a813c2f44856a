#include <ecorche/core/parallel.h>
#include <ecorche/domain/face_samples.h>
#include <ecorche/domain/resample.h>
#include <ecorche/domain/tight_places.h>
#include <ecorche/domain/triangle_tree.h>
#include <ecorche/domain/wall_resampling.h>
#include <ecorche/mesh/self_intersection.h>

#include <algorithm>
#include <cmath>

namespace ecorche::domain {

namespace {

using mesh::Vector3;

// Shares of the tolerance
constexpr double kShareOfTolerance = 0.5;  // for new triangles against the old surface
constexpr double kLoss = 0.75;             // for points of the old surface that are carried along
constexpr double kAccepted = 0.85;         // for all points of the old surface, in the end
constexpr int kRounds = 8;
constexpr double kReach = 2.0;  // edges over which a stricter place wears off
constexpr double kWatch = 2.0;  // edges around a tight place within which no faces may cross
constexpr double kTight = 2.0;  // of the tolerance: walls that are nearer may come to cross

Vector3 corner(const TaggedSurface& s, Eigen::Index f, int k) {
  return s.V.row(s.F(f, k)).transpose();
}
Vector3 middle(const TaggedSurface& s, Eigen::Index f) {
  return (corner(s, f, 0) + corner(s, f, 1) + corner(s, f, 2)) / 3.0;
}

/// Points of the one surface that lie farther than `limit` from the other.
std::vector<Vector3> pointsBeyond(const TaggedSurface& from, const TaggedSurface& to, double limit,
                                  double spacing) {
  const TriangleTree tree(to.V, to.F);
  std::vector<std::vector<Vector3>> beyond(static_cast<std::size_t>(from.F.rows()));
  parallelFor(
      from.F.rows(),
      [&](std::int64_t f) {
        for (const Vector3& p : faceSamples(from.V, from.F, f, spacing)) {
          if (!tree.within(p, limit)) beyond[static_cast<std::size_t>(f)].push_back(p);
        }
      },
      256);
  std::vector<Vector3> out;
  for (const auto& points : beyond) out.insert(out.end(), points.begin(), points.end());
  return out;
}

}  // namespace

Result<WallResampling> resampleWalls(const TaggedSurface& surface,
                                     const std::vector<CutPlane>& cutPlanes,
                                     const SizingField& sizing, double scale, double tolerance,
                                     RunContext& run) {
  const Stage stage(run, "domain: resample");
  // A factor on lengths: 1 at first, halved around every place that did not do, back to 1 over some
  // edges
  std::vector<WantedLength> strict;
  SizingField factor(sizing.box(), strict, 1.0, 1.0);
  TightPlaces tight([&](const Vector3& p) { return kWatch * scale * sizing.at(p); });
  for (const Vector3& p : placesInGaps(surface, kTight * tolerance)) tight.add(p);
  WallResampling out;
  for (;; ++out.rounds) {
    const auto share = [&](const Vector3& p) { return std::pow(factor.at(p), 1.5) * tolerance; };
    const ResampleOptions how{
        .edgeLength = [&](const Vector3& p) { return factor.at(p) * scale * sizing.at(p); },
        .tolerance = [&](const Vector3& p) { return kShareOfTolerance * share(p); },
        .loss = [&](const Vector3& p) { return kLoss * share(p); },
        .spacing = kSampleSpacing * tolerance,
        .watched = [&](const Vector3& p) { return tight.contains(p); }};
    auto resampled = resample(surface, cutPlanes, how, run);
    if (!resampled) return passOn(resampled);
    out.walls = std::move(*resampled);

    std::vector<Vector3> places =
        pointsBeyond(surface, out.walls, kAccepted * tolerance, kSampleSpacing * tolerance);
    const auto crossings = mesh::selfIntersections(out.walls.V, out.walls.F);
    out.crossings = static_cast<std::int64_t>(crossings.size());
    bool news = !places.empty();
    for (const auto& pair : crossings) {
      for (const std::int32_t f : {pair.first, pair.second}) {
        const Vector3 p = middle(out.walls, f);
        news = news || !tight.contains(p);
        tight.add(p);
      }
    }
    // What crosses though it was watched, crossed from the start
    if (!news || out.rounds == kRounds) return out;
    if (places.empty()) continue;

    double length = 0.0;
    for (const Vector3& p : places) length += scale * sizing.at(p);
    length /= static_cast<double>(places.size());
    for (const Vector3& p : places) strict.push_back({p, 0.5 * factor.at(p)});
    factor = SizingField(sizing.box(), strict, 1.0, 1.0 / (kReach * length));
  }
}

}  // namespace ecorche::domain
