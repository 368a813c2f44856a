#include <ecorche/core/give_way.h>
#include <ecorche/engine/bench_settle.h>
#include <ecorche/engine/drag_scene.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/value_fields.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <optional>
#include <thread>

namespace ecorche::engine {

namespace {

using tissue::CurveTissue;

// Everything but the analysis, as a live session does it
struct Hand {
  const DragScene& scene;
  tissue::Settling settling;
  tissue::KeptTraces kept;

  explicit Hand(const DragScene& s) : scene(s), settling(s.solver) {}
  Result<tissue::CoreSamples> trace(const std::vector<CurveTissue>& now, RunContext& run) {
    return tissue::traceCurves(*scene.walker, *scene.domain, now, scene.how, run, kept);
  }
};

// A drag that begins while the one before it is being settled for: what is being solved is given
// up, and frames go on meanwhile.
struct Resumed {
  bool givenUp = false;  // else it was done by then
  double end = 0.0;      // from the cancel until the solve has ended [s]
  std::vector<double> frames;
};

// @param after  the solve has begun so long before [s]
// @param frame  draws the next one of the drag
Result<Resumed> resume(Hand& hand, const tissue::CoreSamples& cores,
                       const std::vector<CurveTissue>& now, double after,
                       const std::function<void()>& frame) {
  RunContext run;
  const Clock clock;
  std::atomic<double> ended = 0.0;
  std::optional<Error> error;
  std::thread solve([&] {
    const GiveWay giveWay;  // as a live session does
    if (const auto settled = hand.settling.solve(cores, now, hand.scene.how, run); !settled)
      error = settled.error();
    ended = clock.seconds();
  });
  std::this_thread::sleep_for(std::chrono::duration<double>(after));
  Resumed out;
  const double cancelled = clock.seconds();
  run.cancel();
  while (ended == 0.0) {
    const Clock one;
    frame();
    out.frames.push_back(one.seconds());
  }
  solve.join();
  if (error && error->code != ErrorCode::Cancelled) return tl::unexpected(*error);
  out.givenUp = error.has_value();
  out.end = ended - cancelled;
  return out;
}

}  // namespace

Result<SettleBench> benchSettle(const model::Project& project, std::optional<std::int64_t> tets,
                                const std::vector<DragScript>& scripts, int places,
                                RunContext& run) {
  const auto scene = prepareDragScene(project, tets, scripts, run);
  if (!scene) return passOn(scene);
  SettleBench out;
  out.tets = scene->domain->mesh.T.rows();
  out.freeVertices = scene->domain->freeVertexCount();
  out.tissues = scene->tissues.size();
  {
    const Clock clock;
    const auto analysed = tissue::TissueSolver::create(*scene->domain, run);
    if (!analysed) return passOn(analysed);
    out.analysis = clock.seconds();
  }
  Hand hand(*scene);
  {
    const Clock clock;
    const auto cores = hand.trace(scene->tissues, run);
    if (!cores) return passOn(cores);
    const auto first = hand.settling.solve(*cores, scene->tissues, scene->how, run);
    if (!first) return passOn(first);
    out.first = clock.seconds();
  }
  for (std::size_t i = 0; i < scripts.size(); ++i) {
    const DragScript& script = scripts[i];
    const tissue::CurveRef curve = scene->curves[i];
    SettleRun done;
    done.name = script.name;
    auto now = scene->tissues;
    for (int place = 1; place <= places; ++place) {
      if (run.cancelled()) return fail(ErrorCode::Cancelled, "bench settle");
      run.progress(script.name, static_cast<double>(place) / places);
      now[curve.tissue].curves[static_cast<std::size_t>(curve.curve)].spline =
          scene->splineAt(script, curve, script.frames * place / (places + 1));
      const Clock clock;
      auto cores = hand.trace(now, run);
      if (!cores) {
        ++done.unchecked;
        continue;
      }
      const double traced = clock.seconds();
      const Clock settling;
      auto settled = hand.settling.solve(*cores, now, scene->how, run);
      if (!settled) return passOn(settled);
      const auto owners = tissue::vertexOwners(settled->fields);
      done.settle.seconds.push_back(traced + settling.seconds());
      done.factored.push_back(settled->factored);
      done.passes.push_back(settled->passes);

      const Clock baseline;
      const auto again = hand.trace(now, run);
      if (!again) return passOn(again);
      const auto fresh = scene->solver->solve(*again, now, scene->how, run);
      if (!fresh) return passOn(fresh);
      const auto ownersAgain = tissue::vertexOwners(*fresh);
      done.again.seconds.push_back(baseline.seconds());
      done.fieldError.push_back((settled->fields.values - fresh->values).cwiseAbs().maxCoeff() /
                                fresh->maxValue);
      for (std::size_t v = 0; v < owners.size(); ++v) done.ownersOff += owners[v] != ownersAgain[v];

      // The hand goes on to halfway to the next place, lets go and takes up the curve again
      auto fields = tissue::ValueFields::create(scene->domain, hand.settling, std::move(*cores),
                                                now, scene->how, run, scene->walker);
      if (!fields) return passOn(fields);
      int frame = script.frames * (2 * place + 1) / (2 * places + 2);
      const auto drag = [&] {
        const auto at = scene->splineAt(script, curve, std::min(frame++, script.frames));
        (void)fields->moveCurves({{curve, at}});
        return at;
      };
      now[curve.tissue].curves[static_cast<std::size_t>(curve.curve)].spline = drag();
      const auto onward = hand.trace(now, run);
      if (!onward) continue;
      const double share = static_cast<double>(place) / (places + 1);
      const auto resumed =
          resume(hand, *onward, now, share * done.settle.quantile(0.5), [&] { (void)drag(); });
      if (!resumed) return passOn(resumed);
      if (!resumed->givenUp) continue;
      done.abandoned.seconds.push_back(resumed->end);
      done.meanwhile.seconds.insert(done.meanwhile.seconds.end(), resumed->frames.begin(),
                                    resumed->frames.end());
    }
    out.runs.push_back(std::move(done));
  }
  return out;
}

}  // namespace ecorche::engine
