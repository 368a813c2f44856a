#include <ecorche/core/contract.h>
#include <ecorche/fiber/curve_guide.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ecorche::fiber {

using mesh::Vector3;

namespace {
constexpr std::size_t kRun = 8;  // segments per ball
constexpr int kBins = 16;        // of thickness along a curve
}  // namespace

CurveGuide::CurveGuide(const tissue::CurveTissue& tissue) {
  for (const auto& curve : tissue.curves) {
    Line line;
    const double length = curve.spline.length();
    const auto samples = curve.spline.sample(length / 64);
    for (std::size_t k = 0; k < samples.u.size(); ++k) {
      line.point.push_back(samples.point[k]);
      line.tangent.push_back(curve.spline.tangent(samples.u[k]));
      line.arc.push_back(curve.spline.lengthTo(samples.u[k]));
    }
    for (std::size_t k = 0; k + 1 < line.point.size(); ++k) {
      line.step.emplace_back(line.point[k + 1] - line.point[k]);
      line.perStep.push_back(1.0 / line.step.back().squaredNorm());
    }
    for (std::size_t first = 0; first + 1 < line.point.size(); first += kRun) {
      const std::size_t last = std::min(first + kRun, line.point.size() - 1);
      const Vector3 centre = 0.5 * (line.point[first] + line.point[last]);
      double radius = 0.0;
      for (std::size_t k = first; k <= last; ++k) {
        radius = std::max(radius, (line.point[k] - centre).norm());
      }
      line.ballCentre.push_back(centre);
      line.ballRadius.push_back(radius);
    }
    lines_.push_back(std::move(line));
  }
}

// The nearest point of one line, where it is nearer than `best`. Runs of segments in balls that are
// too far are skipped, the ball with the nearest centre comes first.
bool CurveGuide::Line::improve(const Vector3& x, Place& best) const {
  std::size_t nearestRun = 0;
  double nearestCentre = std::numeric_limits<double>::infinity();
  for (std::size_t run = 0; run < ballCentre.size(); ++run) {
    const double d = (x - ballCentre[run]).squaredNorm();
    if (d < nearestCentre) {
      nearestCentre = d;
      nearestRun = run;
    }
  }
  bool improved = false;
  const auto visit = [&](std::size_t run) {
    const double reach = std::sqrt(best.squared) + ballRadius[run];
    if ((x - ballCentre[run]).squaredNorm() >= reach * reach) return;
    const std::size_t last = std::min((run + 1) * kRun, point.size() - 1);
    for (std::size_t k = run * kRun; k < last; ++k) {
      const Vector3 off = x - point[k];
      const double s = std::clamp(off.dot(step[k]) * perStep[k], 0.0, 1.0);
      const double squared = (off - s * step[k]).squaredNorm();
      if (squared >= best.squared) continue;
      best = {squared, k, s};
      improved = true;
    }
  };
  visit(nearestRun);
  for (std::size_t run = 0; run < ballCentre.size(); ++run) {
    if (run != nearestRun) visit(run);
  }
  return improved;
}

CurveGuide::Nearest CurveGuide::nearest(const Vector3& x) const {
  Place place;
  std::size_t curve = 0;
  for (std::size_t c = 0; c < lines_.size(); ++c) {
    if (lines_[c].improve(x, place)) curve = c;
  }
  const Line& line = lines_[curve];
  const auto [squared, k, s] = place;
  return {static_cast<std::int32_t>(curve), (1.0 - s) * line.arc[k] + s * line.arc[k + 1],
          std::sqrt(squared), ((1.0 - s) * line.tangent[k] + s * line.tangent[k + 1]).normalized()};
}

double CurveGuide::distance(std::int32_t curve, const Vector3& x) const {
  Place place;
  lines_[static_cast<std::size_t>(curve)].improve(x, place);
  return std::sqrt(place.squared);
}

void CurveGuide::measureThickness(const MuscleMesh& muscle,
                                  const std::vector<Nearest>& nearestOfTet) {
  std::vector<std::array<double, kBins>> volume(lines_.size());
  for (auto& bins : volume) bins.fill(0.0);
  for (std::size_t t = 0; t < nearestOfTet.size(); ++t) {
    const Nearest& n = nearestOfTet[t];
    const double length = lines_[static_cast<std::size_t>(n.curve)].arc.back();
    // What lies past an end is no part of a cross-section
    if (n.arc <= 0.0 || n.arc >= length) continue;
    const int bin = std::min(kBins - 1, static_cast<int>(kBins * n.arc / length));
    volume[static_cast<std::size_t>(n.curve)][static_cast<std::size_t>(bin)] +=
        muscle.volume[static_cast<Eigen::Index>(t)];
  }

  for (std::size_t c = 0; c < lines_.size(); ++c) {
    Line& line = lines_[c];
    const double slab = line.arc.back() / kBins;
    std::vector<double> area(kBins);
    for (int b = 0; b < kBins; ++b)
      area[static_cast<std::size_t>(b)] = volume[c][static_cast<std::size_t>(b)] / slab;
    // Coarse tets fall into bins in lumps: smooth twice with weights 1 2 1
    for (int pass = 0; pass < 2; ++pass) {
      const std::vector<double> before = area;
      for (int b = 0; b < kBins; ++b) {
        const auto at = [&](int k) {
          return before[static_cast<std::size_t>(std::clamp(k, 0, kBins - 1))];
        };
        area[static_cast<std::size_t>(b)] = 0.25 * at(b - 1) + 0.5 * at(b) + 0.25 * at(b + 1);
      }
    }
    double mean = 0.0;
    for (const double a : area) mean += a / kBins;
    line.flux = mean;
    line.radius.clear();
    for (const double a : area) {
      // A pinched stretch still has a tube to speak of
      line.radius.push_back(std::sqrt(std::max(a, 0.05 * mean) / std::numbers::pi));
    }
  }

  // A curve that no tet is nearest to takes the muscle's mean thickness
  double total = 0.0;
  double length = 0.0;
  for (const Line& line : lines_) length += line.arc.back();
  total = muscle.volume.sum();
  const double fallback = std::sqrt(total / (length * std::numbers::pi));
  for (Line& line : lines_) {
    for (double& r : line.radius) {
      if (!(r > 0.0)) r = fallback;
    }
    if (!(line.flux > 0.0)) line.flux = total / length;
  }
}

double CurveGuide::radius(std::int32_t curve, double arc) const {
  const Line& line = lines_[static_cast<std::size_t>(curve)];
  EC_REQUIRE(!line.radius.empty());
  // Bins are centred at (b + ½) slabs
  const double at = std::clamp(kBins * arc / line.arc.back() - 0.5, 0.0, kBins - 1.0);
  const auto b = std::min(static_cast<std::size_t>(at), static_cast<std::size_t>(kBins - 2));
  const double s = at - static_cast<double>(b);
  return (1.0 - s) * line.radius[b] + s * line.radius[b + 1];
}

double CurveGuide::length(std::int32_t curve) const {
  return lines_[static_cast<std::size_t>(curve)].arc.back();
}

Vector3 CurveGuide::end(std::int32_t curve, bool insertion) const {
  const Line& line = lines_[static_cast<std::size_t>(curve)];
  return insertion ? line.point.back() : line.point.front();
}

double CurveGuide::flux(std::int32_t curve) const {
  return lines_[static_cast<std::size_t>(curve)].flux;
}

}  // namespace ecorche::fiber
