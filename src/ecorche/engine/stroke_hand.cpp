#include <ecorche/engine/stroke_hand.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace ecorche::engine {

using authoring::SightRay;
using mesh::Vector3;

namespace {

// FNV-1a: the same number for a name everywhere
std::uint64_t numberOf(const std::string& name) {
  std::uint64_t out = 14695981039346656037ULL;
  for (const char c : name) out = (out ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return out;
}

// A side from which a body is looked at: from there towards it. Cranial +X, left +Y, dorsal +Z.
struct View {
  std::string name;
  Vector3 towardsEye;
};

std::vector<View> viewsAround() {
  std::vector<View> out;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const int axes = std::abs(x) + std::abs(y) + std::abs(z);
        if (axes == 0 || axes == 3) continue;
        std::string name;
        const auto add = [&](int k, const char* minus, const char* plus) {
          if (k == 0) return;
          if (!name.empty()) name += '-';
          name += k < 0 ? minus : plus;
        };
        add(x, "caudal", "cranial");
        add(z, "ventral", "dorsal");
        add(y, "medial", "lateral");
        out.push_back({name, Vector3(x, y, z).normalized()});
      }
    }
  }
  // From the side first, then the more the farther from it
  std::ranges::stable_sort(out, std::greater(),
                           [&](const View& view) { return std::round(1e6 * view.towardsEye.y()); });
  return out;
}

// An eye as in the window, so far away that the muscle takes a third of the picture's height.
class Eye {
 public:
  static constexpr double kFovDeg = 24.0;
  static constexpr double kHeight = 900.0;  // [pixels]

  Eye(const View& view, const Vector3& target, double size) : back_(view.towardsEye) {
    const double half = std::tan(0.5 * kFovDeg * std::numbers::pi / 180.0);
    place_ = target + 1.5 * size / half * back_;
    const Vector3 up = std::abs(back_.z()) > 0.9 ? Vector3::UnitX() : Vector3::UnitZ();
    right_ = up.cross(back_).normalized();
    up_ = back_.cross(right_);
    scale_ = 0.5 * kHeight / half;
  }
  [[nodiscard]] Eigen::Vector2d pixelOf(const Vector3& p) const {
    const Vector3 d = p - place_;
    return scale_ / -d.dot(back_) * Eigen::Vector2d(d.dot(right_), d.dot(up_));
  }
  [[nodiscard]] SightRay sight(const Eigen::Vector2d& pixel) const {
    return {place_, (pixel.x() / scale_ * right_ + pixel.y() / scale_ * up_ - back_).normalized()};
  }

 private:
  Vector3 back_, place_, right_, up_;
  double scale_ = 1.0;
};

// A hand that follows a line in the picture: it wanders by some pixels, slowly, and trembles. Its
// ends are meant: they only tremble.
std::vector<Eigen::Vector2d> drawnBy(std::mt19937_64& hand,
                                     const std::vector<Eigen::Vector2d>& line) {
  constexpr double kStep = 3.0;     // between samples, as the window takes them [pixels]
  constexpr double kWander = 4.0;   // standard deviation [pixels]
  constexpr double kTremble = 0.5;  // likewise
  constexpr double kWaves = 3.0;    // of wandering along the stroke
  std::normal_distribution<double> normal;
  std::array<Eigen::Vector2d, 6> wave;
  for (auto& w : wave) {
    const double x = normal(hand);
    w = {x, normal(hand)};
  }
  std::vector<double> s{0.0};
  for (std::size_t i = 1; i < line.size(); ++i)
    s.push_back(s.back() + (line[i] - line[i - 1]).norm());
  const int steps = std::max(2, static_cast<int>(s.back() / kStep));
  std::vector<Eigen::Vector2d> out;
  std::size_t piece = 1;
  for (int k = 0; k <= steps; ++k) {
    const double share = static_cast<double>(k) / steps;
    while (piece + 1 < line.size() && s[piece] < share * s.back()) ++piece;
    const double gap = s[piece] - s[piece - 1];
    const double t = gap > 0.0 ? (share * s.back() - s[piece - 1]) / gap : 0.0;
    Eigen::Vector2d p = (1.0 - t) * line[piece - 1] + t * line[piece];
    for (int w = 1; w <= 3; ++w)
      p += kWander / std::sqrt(kWaves) * std::sqrt(2.0) * std::sin(std::numbers::pi * w * share) *
           wave[static_cast<std::size_t>(w - 1)];
    const double x = normal(hand);
    p += kTremble * Eigen::Vector2d(x, normal(hand));
    out.push_back(p);
  }
  return out;
}

// Where a line of sight meets the bone that is meant; a trembling hand that misses by a pixel goes
// back [ABLSJ21 §3.2: strokes begin and end over bone].
Vector3 endOver(SightRay& sight, const Eye& eye, const Vector3& meant,
                const mesh::SurfaceQuery& bone) {
  if (const auto hit = bone.firstHit(sight.origin, sight.direction)) return hit->point;
  sight = eye.sight(eye.pixelOf(meant));
  if (const auto hit = bone.firstHit(sight.origin, sight.direction)) return hit->point;
  return sight.origin + (meant - sight.origin).norm() * sight.direction;
}

struct Choice {
  View view;
  Eye eye;
  int hidden = 0;
  bool endOn = false;
};

}  // namespace

std::vector<HandStroke> handStrokes(const KnownMuscle& muscle, const StrokeAtlas& atlas,
                                    bool fixedViews, std::uint64_t seed) {
  constexpr double kSeenRel = 0.002;  // of the diagonal: how near to an end its bone is met
  constexpr double kEndOn = 0.7;      // share of the chord that is to be seen
  const mesh::SurfaceQuery& fromBone =
      *atlas.bones[static_cast<std::size_t>(muscle.fromBone)].surface;
  const mesh::SurfaceQuery& toBone = *atlas.bones[static_cast<std::size_t>(muscle.toBone)].surface;
  std::vector<Vector3> line = muscle.centreline;
  line.front() = muscle.origin;
  line.back() = muscle.insertion;
  mesh::Box box;
  for (const Vector3& p : line) box.add(p);
  const Vector3 chord = muscle.insertion - muscle.origin;

  std::vector<Choice> choices;
  for (const View& view : viewsAround()) {
    const Eye eye(view, box.centre(), std::max(muscle.length, chord.norm()));
    const auto isHidden = [&](const Vector3& at, const mesh::SurfaceQuery& bone) {
      const SightRay sight = eye.sight(eye.pixelOf(at));
      const auto hit = bone.firstHit(sight.origin, sight.direction);
      return !hit || (hit->point - at).norm() > kSeenRel * atlas.diagonal;
    };
    const int hidden =
        (isHidden(muscle.origin, fromBone) ? 1 : 0) + (isHidden(muscle.insertion, toBone) ? 1 : 0);
    const bool endOn = chord.cross(view.towardsEye).norm() < kEndOn * chord.norm();
    choices.push_back({view, eye, hidden, endOn});
  }
  if (fixedViews) {
    std::erase_if(choices, [](const Choice& c) {
      return c.view.name != "lateral" && c.view.name != "cranial-lateral" &&
             c.view.name != "caudal-lateral";
    });
  } else {
    std::ranges::stable_sort(choices, {},
                             [](const Choice& c) { return 2 * c.hidden + (c.endOn ? 1 : 0); });
  }
  choices.resize(3, choices.front());

  std::vector<HandStroke> out;
  for (std::size_t v = 0; v < choices.size(); ++v) {
    const Eye& eye = choices[v].eye;
    std::mt19937_64 hand(numberOf(muscle.name + muscle.from + muscle.to) + 1'000'003 * seed + v);
    std::vector<Eigen::Vector2d> seen;
    for (const Vector3& p : line) seen.push_back(eye.pixelOf(p));
    HandStroke stroke;
    stroke.view = choices[v].view.name;
    stroke.hidden = choices[v].hidden;
    for (const auto& pixel : drawnBy(hand, seen)) stroke.sights.push_back(eye.sight(pixel));
    stroke.from = endOver(stroke.sights.front(), eye, muscle.origin, fromBone);
    stroke.to = endOver(stroke.sights.back(), eye, muscle.insertion, toBone);
    out.push_back(std::move(stroke));
  }
  return out;
}

}  // namespace ecorche::engine
