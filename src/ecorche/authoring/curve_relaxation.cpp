#include <ecorche/authoring/curve_relaxation.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/spline.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace ecorche::authoring {

using mesh::Vector3;

namespace {

constexpr double kClearanceRel = 0.003;  // of the body's diagonal
constexpr double kApartRel = 0.004;
constexpr double kClearanceOfLength = 0.06;  // a short curve cannot keep more
constexpr int kFewestSteps = 12;
constexpr int kMostSteps = 96;

// A beam: pushed points want their place with weight 1 and more, the others hardly at all
constexpr double kStiffness = 0.02;
constexpr double kInertia = 0.02;
constexpr double kGuidePull = 0.03;
constexpr double kFirmest = 1e3;
constexpr int kRounds = 60;
constexpr int kWallRounds = 15;       // after those with neighbours: walls have the last word
constexpr double kGoodEnough = 0.05;  // of the clearance

std::vector<double> lengthsTo(const std::vector<Vector3>& line) {
  std::vector<double> s{0.0};
  for (std::size_t i = 1; i < line.size(); ++i)
    s.push_back(s.back() + (line[i] - line[i - 1]).norm());
  return s;
}

// The same line in so many equal steps.
std::vector<Vector3> inEqualSteps(const std::vector<Vector3>& line, std::size_t steps) {
  const std::vector<double> s = lengthsTo(line);
  std::vector<Vector3> out;
  std::size_t piece = 1;
  for (std::size_t k = 0; k <= steps; ++k) {
    const double at = s.back() * static_cast<double>(k) / static_cast<double>(steps);
    while (piece + 1 < line.size() && s[piece] < at) ++piece;
    const double length = s[piece] - s[piece - 1];
    const double share = length > 0.0 ? std::clamp((at - s[piece - 1]) / length, 0.0, 1.0) : 0.0;
    out.push_back(line[piece - 1] + share * (line[piece] - line[piece - 1]));
  }
  out.back() = line.back();
  return out;
}

// A band while it moves: what each point wants, how firmly, and when it was last compared with
// walls.
class MovingBand {
 public:
  explicit MovingBand(Band& band)
      : band_(band), firmness_(band.points.size(), kInertia), asked_(band.points.size()) {}

  /// Pushes that walls ask for; returns how much clearance is missing at the worst point, over it.
  double askWalls(const FreeSpace& space) {
    const std::size_t last = band_.points.size() - 1;
    push_.assign(last + 1, Vector3::Zero());
    length_ = lengthsTo(band_.points);
    double missing = 0.0;
    for (std::size_t i = 1; i < last; ++i) {
      const Vector3& x = band_.points[i];
      const double clearance = band_.clearance * ease(i);
      if (asked_[i] && (x - asked_[i]->at).norm() < asked_[i]->room - clearance) continue;
      const FreeSpace::Push push = space.push(x, clearance, 4.0 * band_.clearance);
      asked_[i] = Asked{x, push.room};
      push_[i] = push.step;
      missing = std::max(missing, clearance - push.room);
    }
    if (!band_.planeNormal.isZero()) {
      for (std::size_t i = 1; i < last; ++i) {
        const double height = (band_.points[i] - band_.planePoint).dot(band_.planeNormal);
        const double lack = band_.clearance * ease(i) - height;
        if (lack <= 0.0) continue;
        push_[i] += lack * band_.planeNormal;
        missing = std::max(missing, lack);
      }
    }
    return missing / band_.clearance;
  }

  void addPush(std::size_t i, const Vector3& push) { push_[i] += push; }

  /// Share of a distance that counts at a point: nothing at the ends.
  [[nodiscard]] double ease(std::size_t i) const {
    return easeNearEnd(std::min(length_[i], length_.back() - length_[i]), band_.clearance);
  }

  /// Σ a_i |x_i − t_i|² + λ Σ |x_{i−1} − 2x_i + x_{i+1}|² at its least, ends fixed. λ grows with
  /// the cube of the steps, so that it is the same beam at every step.
  void move() {
    const auto last = static_cast<Eigen::Index>(band_.points.size()) - 1;
    const double lambda = kStiffness * std::pow(static_cast<double>(last), 3) / 48.0;
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(last - 1, last - 1);
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(last - 1, 3);
    for (Eigen::Index i = 1; i < last; ++i) {
      const std::array<double, 3> stencil{1.0, -2.0, 1.0};
      for (int r = -1; r <= 1; ++r) {
        if (i + r == 0 || i + r == last) continue;
        for (int c = -1; c <= 1; ++c) {
          const double k = lambda * stencil[static_cast<std::size_t>(r + 1)] *
                           stencil[static_cast<std::size_t>(c + 1)];
          const Eigen::Index column = i + c;
          if (column == 0 || column == last) {
            b.row(i + r - 1) -= k * band_.points[static_cast<std::size_t>(column)].transpose();
          } else {
            A(i + r - 1, column - 1) += k;
          }
        }
      }
      const auto at = static_cast<std::size_t>(i);
      const bool pushed = !push_[at].isZero(0.0);
      firmness_[at] = pushed ? std::min(kFirmest, std::max(1.0, 1.5 * firmness_[at]))
                             : std::max(kInertia, 0.7 * firmness_[at]);
      A(i - 1, i - 1) += firmness_[at];
      b.row(i - 1) += firmness_[at] * (band_.points[at] + push_[at]).transpose();
      if (!band_.guide.empty()) {
        A(i - 1, i - 1) += kGuidePull;
        b.row(i - 1) += kGuidePull * band_.guide[at].transpose();
      }
    }
    const Eigen::MatrixXd x = A.llt().solve(b);
    for (Eigen::Index i = 1; i < last; ++i)
      band_.points[static_cast<std::size_t>(i)] = x.row(i - 1).transpose();
  }

  void respace() {
    band_.points = inEqualSteps(band_.points, band_.points.size() - 1);
    std::ranges::fill(asked_, std::nullopt);
  }

 private:
  struct Asked {
    Vector3 at;
    double room;
  };
  Band& band_;
  std::vector<double> firmness_;
  std::vector<std::optional<Asked>> asked_;
  std::vector<Vector3> push_;
  std::vector<double> length_;
};

// A point of another band that is too near, or would be without the ends.
struct Neighbour {
  Vector3 point;
  Vector3 direction;  // of the band there
  double distance = std::numeric_limits<double>::infinity();
  double fromEnd = 0.0;
};

struct BandImage {
  std::vector<Vector3> points;
  std::vector<double> length;
  Vector3 lo, hi;
  double apart = 0.0;
  int muscle = 0;
  bool mirrored = false;
};

BandImage imageOf(const Band& band) {
  BandImage out{
      band.points, lengthsTo(band.points), band.points[0], band.points[0], band.apart, band.muscle,
      false};
  for (const Vector3& p : band.points) {
    out.lo = out.lo.cwiseMin(p);
    out.hi = out.hi.cwiseMax(p);
  }
  return out;
}

Neighbour nearestOn(const BandImage& other, const Vector3& x) {
  Neighbour best;
  for (std::size_t k = 1; k < other.points.size(); ++k) {
    const Vector3 step = other.points[k] - other.points[k - 1];
    const double t = std::clamp((x - other.points[k - 1]).dot(step) / step.squaredNorm(), 0.0, 1.0);
    const Vector3 foot = other.points[k - 1] + t * step;
    const double distance = (x - foot).norm();
    if (distance >= best.distance) continue;
    const double s = other.length[k - 1] + t * step.norm();
    best = {foot, step.normalized(), distance, std::min(s, other.length.back() - s)};
  }
  return best;
}

}  // namespace

double easeNearEnd(double fromEnd, double clearance) {
  return std::min(1.0, fromEnd / (3.0 * clearance));
}

Band bandThrough(const Vector3& from, const std::vector<Vector3>& along, const Vector3& to,
                 double diagonal) {
  std::vector<Vector3> line{from};
  line.insert(line.end(), along.begin(), along.end());
  line.push_back(to);
  const double length = lengthsTo(line).back();
  Band out;
  out.clearance = std::min(kClearanceRel * diagonal, kClearanceOfLength * length);
  out.apart = std::min(kApartRel * diagonal, 2.0 * kClearanceOfLength * length);
  const auto steps = static_cast<std::size_t>(std::clamp(std::ceil(length / out.clearance),
                                                         static_cast<double>(kFewestSteps),
                                                         static_cast<double>(kMostSteps)));
  out.points = inEqualSteps(line, steps);
  if (!along.empty()) out.guide = out.points;
  return out;
}

double settleNearby(Band& band, const FreeSpace& space) {
  MovingBand moving(band);
  Band best = band;
  double least = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kRounds; ++round) {
    const double missing = moving.askWalls(space);
    if (missing < least) {
      least = missing;
      best = band;
    }
    if (missing < kGoodEnough) break;
    moving.move();
    if (round % 10 == 9) moving.respace();
  }
  band = std::move(best);
  return least;
}

double settle(Band& band, const FreeSpace& space) {
  const std::vector<Vector3> start = band.points;
  double best = settleNearby(band, space);
  constexpr double kPoor = 0.5;
  if (best < kPoor) return best;

  const Vector3 chord = start.back() - start.front();
  Eigen::Index across = 0;
  chord.cwiseAbs().minCoeff(&across);
  const Vector3 e1 = chord.cross(Vector3::Unit(across)).normalized();
  const Vector3 e2 = chord.cross(e1).normalized();
  constexpr int kSides = 8;
  constexpr double kDetour = 0.3;  // of the chord
  for (int side = 0; side < kSides; ++side) {
    const double angle = 2.0 * std::numbers::pi * side / kSides;
    const Vector3 off = kDetour * chord.norm() * (std::cos(angle) * e1 + std::sin(angle) * e2);
    Band detour = band;
    for (std::size_t i = 0; i < start.size(); ++i) {
      const double share = static_cast<double>(i) / static_cast<double>(start.size() - 1);
      detour.points[i] = start[i] + std::sin(std::numbers::pi * share) * off;
    }
    detour.points.back() = start.back();
    const double missing = settleNearby(detour, space);
    // A longer way has to be better by something
    if (missing < 0.8 * best - 0.02) {
      best = missing;
      band.points = std::move(detour.points);
    }
  }
  return best;
}

void settleTogether(std::vector<Band>& bands, const FreeSpace& space, const Vector3& mirrorPoint,
                    const Vector3& mirrorNormal) {
  if (bands.empty()) return;
  std::vector<MovingBand> moving;
  moving.reserve(bands.size());
  for (Band& band : bands) moving.emplace_back(band);
  for (int round = 0; round < kRounds + kWallRounds; ++round) {
    const bool wallsAlone = round >= kRounds;
    std::vector<BandImage> others;
    for (const Band& band : bands) {
      if (!wallsAlone) others.push_back(imageOf(band));
    }
    if (!mirrorNormal.isZero() && !wallsAlone) {
      for (const Band& band : bands) {
        if (band.planeNormal.isZero()) continue;
        Band image = band;
        for (Vector3& p : image.points)
          p -= 2.0 * (p - mirrorPoint).dot(mirrorNormal) * mirrorNormal;
        others.push_back(imageOf(image));
        others.back().mirrored = true;
      }
    }
    std::vector<double> missing(bands.size());
    parallelFor(
        std::ssize(bands),
        [&](std::int64_t b) {
          const auto at = static_cast<std::size_t>(b);
          const Band& band = bands[at];
          missing[at] = moving[at].askWalls(space);
          const BandImage self = imageOf(band);
          for (const BandImage& other : others) {
            const double apart = std::min(band.apart, other.apart);
            const bool far = ((other.lo - self.hi).array() > apart).any() ||
                             ((self.lo - other.hi).array() > apart).any();
            if (far || (other.muscle == band.muscle && !other.mirrored)) continue;
            for (std::size_t i = 1; i + 1 < band.points.size(); ++i) {
              const Vector3& x = band.points[i];
              const Neighbour near = nearestOn(other, x);
              const double wanted =
                  apart * std::min(moving[at].ease(i), easeNearEnd(near.fromEnd, band.clearance));
              if (near.distance >= wanted) continue;
              Vector3 away = (x - near.point) / std::max(near.distance, 1e-300);
              // Curves that cross part to either side of their common plane
              if (near.distance < 0.1 * apart) {
                const Vector3 own = (band.points[i + 1] - band.points[i - 1]).normalized();
                const Vector3 normal = own.cross(near.direction);
                if (normal.norm() > 0.1) away = normal.normalized();
              }
              moving[at].addPush(i, 0.5 * (wanted - near.distance) * away);
              missing[at] = std::max(missing[at], 0.5 * (wanted - near.distance) / band.clearance);
            }
          }
        },
        1);
    if (*std::ranges::max_element(missing) < kGoodEnough) break;
    parallelFor(
        std::ssize(bands),
        [&](std::int64_t b) {
          MovingBand& each = moving[static_cast<std::size_t>(b)];
          if (wallsAlone && missing[static_cast<std::size_t>(b)] < kGoodEnough) return;
          each.move();
          if (round % 10 == 9) each.respace();
        },
        1);
  }
}

std::vector<Vector3> controlPoints(const Band& band, const FreeSpace& space) {
  constexpr std::size_t kMostPoints = 20;
  constexpr double kShare = 0.5;  // of the clearance
  const double steps = static_cast<double>(band.points.size()) - 1.0;
  const auto at = [&](double place) -> Vector3 {
    const auto i = std::min(static_cast<std::size_t>(place), band.points.size() - 2);
    return band.points[i] +
           (place - static_cast<double>(i)) * (band.points[i + 1] - band.points[i]);
  };
  const BandImage image = imageOf(band);

  std::vector<double> places{0.0, steps / 3.0, 2.0 * steps / 3.0, steps};
  for (;;) {
    std::vector<Vector3> points;
    for (double place : places) points.push_back(at(place));
    points.back() = band.points.back();
    if (places.size() == kMostPoints) return points;

    const mesh::Spline spline(points);
    const auto samples = spline.sample(0.5 * spline.length() / steps);
    double worst = 0.0, where = -1.0;
    for (std::size_t k = 0; k < samples.u.size(); ++k) {
      const double u = samples.u[k];
      const auto piece = std::min(static_cast<std::size_t>(u), places.size() - 2);
      const double place =
          places[piece] + (u - static_cast<double>(piece)) * (places[piece + 1] - places[piece]);
      // Not beside a point that is there already
      if (place - places[piece] < 1.0 || places[piece + 1] - place < 1.0) continue;
      const double s = spline.lengthTo(u);
      const double clearance =
          band.clearance * easeNearEnd(std::min(s, spline.length() - s), band.clearance);
      const double lack = kShare * clearance - space.room(samples.point[k], clearance);
      const double stray = nearestOn(image, samples.point[k]).distance - kShare * band.clearance;
      if (std::max(lack, stray) <= worst) continue;
      worst = std::max(lack, stray);
      where = place;
    }
    if (where < 0.0) return points;
    places.insert(std::ranges::upper_bound(places, where), where);
  }
}

}  // namespace ecorche::authoring
