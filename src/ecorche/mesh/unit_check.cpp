#include <ecorche/mesh/unit_check.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace ecorche::mesh {

namespace {

constexpr std::array<double, 4> kFactors{10.0, 25.4, 100.0, 1000.0};

Box times(const Box& box, double factor) { return {factor * box.lo, factor * box.hi}; }

/// Inside, or no farther out than a claw.
bool fits(const Box& inner, const Box& outer) {
  const Vector3 room = Vector3::Constant(0.1 * outer.diagonal());
  return (inner.lo.array() >= (outer.lo - room).array()).all() &&
         (inner.hi.array() <= (outer.hi + room).array()).all();
}
bool apart(const Box& a, const Box& b) {
  return (a.lo.array() > b.hi.array()).any() || (b.lo.array() > a.hi.array()).any();
}

/// The smallest change of unit that brings the box into the skin.
std::optional<double> shrinking(const Box& box, const Box& skin) {
  for (const double factor : kFactors) {
    if (fits(times(box, 1.0 / factor), skin)) return factor;
  }
  return std::nullopt;
}
/// The largest change of unit that leaves the box in the skin.
std::optional<double> growing(const Box& box, const Box& skin) {
  std::optional<double> out;
  for (const double factor : kFactors) {
    if (fits(times(box, factor), skin)) out = factor;
  }
  return out;
}

struct Mistake {
  double factor;
  const char* fine;
  const char* coarse;
};
constexpr std::array<Mistake, 4> kMistakes{{{10.0, "centimetres", "decimetres"},
                                            {25.4, "millimetres", "inches"},
                                            {100.0, "centimetres", "metres"},
                                            {1000.0, "millimetres", "metres"}}};

/// @param what    the mesh and its verb: "\"femur\" measures"
/// @param factor  one of those above: too large so many times, or too small
std::string sentence(const std::string& what, double size, double skinSize, double factor,
                     bool tooLarge) {
  const Mistake& m = *std::ranges::find(kMistakes, factor, &Mistake::factor);
  return fmt::format(
      "{} {:.3g} m corner to corner and the skin {:.3g} m; {} times {} it would lie inside, as if "
      "{} had been taken for {}: give the mesh that is wrong a \"unit\" of its own in the project",
      what, size, skinSize, factor, tooLarge ? "smaller" : "larger", tooLarge ? m.fine : m.coarse,
      tooLarge ? m.coarse : m.fine);
}

/// The median of ascending sizes but for one of them.
double middleOfOthers(const std::vector<double>& sizes, double own) {
  const auto rank = std::ranges::lower_bound(sizes, own) - sizes.begin();
  const std::ptrdiff_t half = (std::ssize(sizes) - 2) / 2;
  return sizes[static_cast<std::size_t>(half < rank ? half : half + 1)];
}

}  // namespace

std::vector<UnitMismatch> unitMismatches(const SurfaceMesh& skin,
                                         const std::vector<SurfaceMesh>& bones) {
  constexpr double kLarger = 1.2;     // than the skin: no bone is
  constexpr double kSmall = 0.15;     // of the skin: all bones together are seldom less
  constexpr double kFilled = 0.35;    // of the skin, that all bones in the right unit would span
  constexpr double kPlausible = 0.2;  // of the skin, or of the bone in the middle: less is no bone
  constexpr double kOddlyLarge = 4;   // than the bone in the middle
  constexpr double kOddlySmall = 0.02;

  std::vector<UnitMismatch> out;
  const Box skinBox = boundingBox(skin);
  if (skinBox.empty() || bones.empty()) return out;
  std::vector<Box> boxes;
  std::vector<double> sizes;
  Box all;
  for (const SurfaceMesh& bone : bones) {
    boxes.push_back(boundingBox(bone));
    if (boxes.back().empty()) continue;
    all.add(boxes.back());
    sizes.push_back(boxes.back().diagonal());
  }
  if (sizes.empty() || !all.lo.allFinite() || !all.hi.allFinite()) return out;
  const double skinSize = skinBox.diagonal();
  std::ranges::sort(sizes);

  // All of them
  const std::string every = bones.size() == 1
                                ? fmt::format("\"{}\" measures", bones.front().name)
                                : fmt::format("the bones (\"{}\" and {} more) measure together",
                                              bones.front().name, bones.size() - 1);
  const auto outside = [&](const Box& box) {
    return box.diagonal() > kLarger * skinSize ||
           (apart(box, skinBox) && box.diagonal() > skinSize);
  };
  const bool allOutside = std::ranges::all_of(
      boxes, [&](const Box& box) { return box.empty() || !fits(box, skinBox); });
  if (allOutside && outside(all)) {
    const auto factor = shrinking(all, skinBox);
    if (factor && all.diagonal() > kPlausible * *factor * skinSize) {
      out.push_back(
          {std::nullopt, *factor, true, sentence(every, all.diagonal(), skinSize, *factor, true)});
      return out;
    }
  }
  if (all.diagonal() < kSmall * skinSize && fits(all, skinBox)) {
    const auto factor = growing(all, skinBox);
    if (factor && *factor * all.diagonal() > kFilled * skinSize) {
      out.push_back({std::nullopt, 1.0 / *factor, false,
                     sentence(every, all.diagonal(), skinSize, *factor, false)});
      return out;
    }
  }
  if (sizes.size() < 2) return out;

  // One among others
  for (std::size_t b = 0; b < bones.size(); ++b) {
    const Box& box = boxes[b];
    if (box.empty()) continue;
    const std::string what = fmt::format("\"{}\" measures", bones[b].name);
    const double usual = middleOfOthers(sizes, box.diagonal());
    const bool large = box.diagonal() > kLarger * skinSize ||
                       (apart(box, skinBox) && box.diagonal() > kOddlyLarge * usual);
    if (large) {
      const auto factor = shrinking(box, skinBox);
      if (factor && box.diagonal() > kPlausible * *factor * usual) {
        out.push_back({b, *factor, true, sentence(what, box.diagonal(), skinSize, *factor, true)});
      }
    } else if (box.diagonal() < kOddlySmall * usual) {
      const auto factor = growing(box, skinBox);
      const double then = factor ? *factor * box.diagonal() : 0.0;
      if (then > 0.2 * usual) {
        out.push_back(
            {b, 1.0 / *factor, false, sentence(what, box.diagonal(), skinSize, *factor, false)});
      }
    }
  }
  return out;
}

}  // namespace ecorche::mesh
