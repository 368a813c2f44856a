#include <ecorche/authoring/stroke.h>
#include <ecorche/engine/stroke_bench.h>
#include <ecorche/engine/stroke_hand.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <limits>

namespace ecorche::engine {

using mesh::Vector3;

namespace {

double distanceTo(const Vector3& x, const std::vector<Vector3>& line) {
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < line.size(); ++k) {
    const Vector3 step = line[k] - line[k - 1];
    const double square = step.squaredNorm();
    const double t =
        square > 0.0 ? std::clamp((x - line[k - 1]).dot(step) / square, 0.0, 1.0) : 0.0;
    best = std::min(best, (x - line[k - 1] - t * step).norm());
  }
  return best;
}

CurveFit fitOf(const std::vector<Vector3>& points, const std::vector<Vector3>& centreline,
               const authoring::StrokeRoom& room) {
  constexpr int kSamples = 100;
  const mesh::Spline curve(points);
  const double length = curve.length();
  std::vector<Vector3> line;
  for (int k = 0; k <= kSamples; ++k)
    line.push_back(curve.at(curve.parameterAt(length * k / kSamples)));
  CurveFit out;
  out.points = points.size();
  for (const Vector3& p : line) {
    const double d = distanceTo(p, centreline);
    out.distance += d / static_cast<double>(line.size());
    out.farthest = std::max(out.farthest, d);
  }
  for (const Vector3& p : centreline)
    out.back += distanceTo(p, line) / static_cast<double>(centreline.size());
  out.leaves = authoring::firstLeaving(curve, room).has_value();
  return out;
}

// Sixty of those with one way, evenly through their names; or what is left, and all other ways.
std::vector<const KnownMuscle*> chosenFrom(const StrokeAtlas& atlas,
                                           const StrokeBenchOptions& options) {
  std::vector<const KnownMuscle*> single, out;
  for (const KnownMuscle& muscle : atlas.muscles) {
    if (muscle.single) single.push_back(&muscle);
  }
  std::ranges::stable_sort(single, {}, &KnownMuscle::name);
  if (single.size() < options.muscles) return {};
  for (std::size_t k = 0; k < single.size(); ++k) {
    const bool measured =
        k * options.muscles / single.size() != (k + 1) * options.muscles / single.size();
    if (measured == (options.set == StrokeSet::Measured)) out.push_back(single[k]);
  }
  if (options.set == StrokeSet::Measured) return out;
  for (const KnownMuscle& muscle : atlas.muscles) {
    if (!muscle.single) out.push_back(&muscle);
  }
  return out;
}

}  // namespace

Result<StrokeBench> benchStrokes(const StrokeAtlas& atlas, const StrokeBenchOptions& options,
                                 RunContext& run) {
  const std::vector<const KnownMuscle*> chosen = chosenFrom(atlas, options);
  if (chosen.empty())
    return fail(ErrorCode::ValueOutOfRange,
                fmt::format("there are fewer than {} muscles with one origin and one insertion",
                            options.muscles));
  const authoring::StrokeRoom room{atlas.skin.get(), atlas.bones, {}, atlas.diagonal};
  StrokeBench out;
  for (std::size_t m = 0; m < chosen.size(); ++m) {
    const KnownMuscle& muscle = *chosen[m];
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "drawing muscles");
    run.progress("drawing", static_cast<double>(m) / static_cast<double>(chosen.size()));
    for (const HandStroke& stroke : handStrokes(muscle, atlas, options.fixedViews, options.seed)) {
      StrokeCase c{.muscle = muscle.name,
                   .from = muscle.from,
                   .to = muscle.to,
                   .view = stroke.view,
                   .hidden = stroke.hidden,
                   .length = muscle.length};
      const std::vector<Vector3> linear =
          authoring::strokeInDepth(stroke.sights, stroke.from, stroke.to);
      c.paper = fitOf(authoring::fittedStroke(linear), muscle.centreline, room);
      c.bent = fitOf(authoring::strokeCurve(linear, room).points, muscle.centreline, room);
      const auto begin = std::chrono::steady_clock::now();
      const auto ours = authoring::strokeCurve(
          authoring::strokeInFlesh(stroke.sights, stroke.from, stroke.to, room, options.habits),
          room);
      c.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      c.ours = fitOf(ours.points, muscle.centreline, room);
      out.cases.push_back(std::move(c));
    }
  }
  return out;
}

}  // namespace ecorche::engine
