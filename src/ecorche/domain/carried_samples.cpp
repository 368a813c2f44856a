#include <ecorche/domain/carried_samples.h>
#include <ecorche/domain/triangle_tree.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ecorche::domain {

using mesh::Vector3;

namespace {
constexpr double kMostPieces = 12.0;  // of a side, as faceSamples
}

CarriedSamples::CarriedSamples(const TaggedSurface& surface, double spacing,
                               const std::function<double(const Vector3&)>& limit)
    : ofFace_(static_cast<std::size_t>(surface.F.rows())) {
  const auto pieces = [&](double length) {
    return static_cast<int>(std::clamp(std::ceil(length / spacing), 2.0, kMostPieces));
  };
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(surface.V.rows()), 0);
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f) {
    const auto add = [&](const Vector3& p) {
      const double r = limit(p);
      ofFace_[static_cast<std::size_t>(f)].push_back(static_cast<std::int32_t>(samples_.size()));
      samples_.push_back({p, r * r, 0.0});
    };
    std::array<Vector3, 3> corner;
    for (int k = 0; k < 3; ++k)
      corner[static_cast<std::size_t>(k)] = surface.V.row(surface.F(f, k));
    double longest = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3& a = corner[k];
      const Vector3 side = corner[(k + 1) % 3] - a;
      longest = std::max(longest, side.norm());
      const auto from = surface.F(f, static_cast<Eigen::Index>(k));
      if (std::uint8_t& known = seen[static_cast<std::size_t>(from)]; known == 0) {
        known = 1;
        add(a);
      }
      // A side has two faces; the one that it runs up in takes its points
      if (from > surface.F(f, static_cast<Eigen::Index>((k + 1) % 3))) continue;
      const int n = pieces(side.norm());
      for (int i = 1; i < n; ++i) add(a + side * i / n);
    }
    const int n = pieces(longest);
    for (int i = 1; i < n; ++i) {
      for (int j = 1; i + j < n; ++j)
        add(corner[0] + (corner[1] - corner[0]) * i / n + (corner[2] - corner[0]) * j / n);
    }
  }
}

std::vector<std::int32_t>& CarriedSamples::of(std::int32_t face) {
  const auto f = static_cast<std::size_t>(face);
  if (f >= ofFace_.size()) ofFace_.resize(f + 1);
  return ofFace_[f];
}

bool CarriedSamples::nearest(const SurfaceStep& step, bool limited) {
  moves_.clear();
  for (const std::int32_t face : step.before) {
    for (const std::int32_t s : of(face)) {
      const Sample& sample = samples_[static_cast<std::size_t>(s)];
      Move move{s, -1, std::numeric_limits<double>::infinity()};
      for (const NewFace& candidate : step.after) {
        const auto& [a, b, c] = candidate.corners.at;
        const double d2 = (closestOnTriangle(sample.at, a, b, c) - sample.at).squaredNorm();
        if (d2 < move.distance2) move = {s, candidate.face, d2};
      }
      if (limited && move.distance2 > std::max(sample.limit2, sample.distance2)) return false;
      moves_.push_back(move);
    }
  }
  return true;
}

bool CarriedSamples::allows(const SurfaceStep& step) { return nearest(step, true); }

void CarriedSamples::follow(const SurfaceStep& step) {
  for (const std::int32_t face : step.before) of(face).clear();
  for (const NewFace& face : step.after) of(face.face);  // may be new
  for (const Move& move : moves_) {
    samples_[static_cast<std::size_t>(move.sample)].distance2 = move.distance2;
    of(move.face).push_back(move.sample);
  }
}

void CarriedSamples::followAnyway(const SurfaceStep& step) {
  nearest(step, false);
  follow(step);
}

}  // namespace ecorche::domain
