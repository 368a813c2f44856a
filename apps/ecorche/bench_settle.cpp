#include <ecorche/core/parallel.h>
#include <ecorche/engine/bench_settle.h>
#include <fmt/format.h>

#include <memory>

#include "bench.h"
#include "recorded_drags.h"
#include "table.h"

namespace ecorche::cli {

namespace {

struct SettleArguments {
  std::string project;
  std::string script;
  std::string tets;
  int anisotropic = 0;
  int places = 10;
};

Result<void> runSettle(const SettleArguments& args, Session& session) {
  const auto given = loadRecordedDrags(args.project, args.script, args.tets, args.anisotropic);
  if (!given) return passOn(given);
  const auto bench =
      engine::benchSettle(given->project, given->tets, given->scripts, args.places, session.run);
  if (!bench) return passOn(bench);

  auto json = benchHeader("settle");
  Table table({{"let go of", Table::Align::Left},
               {"p50 ms", Table::Align::Right},
               {"p95 ms", Table::Align::Right},
               {"max ms", Table::Align::Right},
               {"solving again ms", Table::Align::Right},
               {"faster", Table::Align::Right},
               {"given up after ms", Table::Align::Right},
               {"frames meanwhile, p95 ms", Table::Align::Right},
               {"factored, %", Table::Align::Right},
               {"passes", Table::Align::Right},
               {"fields off", Table::Align::Right},
               {"owners off", Table::Align::Right},
               {"places", Table::Align::Right}});
  for (const engine::SettleRun& run : bench->runs) {
    const double p50 = run.settle.quantile(0.5);
    const double again = run.again.quantile(0.5);
    const int passes = run.passes.empty() ? 0 : *std::ranges::max_element(run.passes);
    json["cases"].push_back(
        {{"name", run.name},
         {"tets", bench->tets},
         {"muscles", bench->tissues},
         {"threads", threadCount()},
         {"metrics",
          {{"free_vertices", bench->freeVertices},
           {"p50_ms", 1e3 * p50},
           {"p95_ms", 1e3 * run.settle.quantile(0.95)},
           {"max_ms", 1e3 * run.settle.quantile(1.0)},
           {"cholmod_refactor_ms", 1e3 * again},
           {"given_up_max_ms", 1e3 * run.abandoned.quantile(1.0)},
           {"meanwhile_p95_ms", 1e3 * run.meanwhile.quantile(0.95)},
           {"meanwhile_max_ms", 1e3 * run.meanwhile.quantile(1.0)},
           {"meanwhile_frames", run.meanwhile.seconds.size()},
           {"factored_share", largest(run.factored)},
           {"passes", passes},
           {"first_ms", 1e3 * bench->first},
           {"analysis_ms", 1e3 * bench->analysis},
           {"places", run.fieldError.size()},
           {"places_outside", run.unchecked}}},
         {"ratios", {{"vs_cholmod_refactor", again / p50}}},
         {"errors", {{"field_rel", largest(run.fieldError)}, {"owners_other", run.ownersOff}}}});
    table.add({run.name, fmt::format("{:.0f}", 1e3 * p50),
               fmt::format("{:.0f}", 1e3 * run.settle.quantile(0.95)),
               fmt::format("{:.0f}", 1e3 * run.settle.quantile(1.0)),
               fmt::format("{:.0f}", 1e3 * again), fmt::format("{:.1f} times", again / p50),
               fmt::format("{:.0f}", 1e3 * run.abandoned.quantile(1.0)),
               fmt::format("{:.1f}", 1e3 * run.meanwhile.quantile(0.95)),
               fmt::format("{:.0f}", 100.0 * largest(run.factored)), fmt::format("{}", passes),
               fmt::format("{:.1e}", largest(run.fieldError)), fmt::format("{}", run.ownersOff),
               fmt::format("{} of {}", run.fieldError.size(),
                           run.fieldError.size() + static_cast<std::size_t>(run.unchecked))});
  }
  if (session.globals.json) {
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print(
        "{} tets, {} free vertices, {} tissues; solved for the first time: {:.0f} ms, after "
        "{:.0f} ms of analysis\n\n{}",
        bench->tets, bench->freeVertices, bench->tissues, 1e3 * bench->first, 1e3 * bench->analysis,
        table.text());
  }
  return {};
}

}  // namespace

void addBenchSettle(CLI::App& bench, Commands& commands) {
  auto args = std::make_shared<SettleArguments>();
  CLI::App* settle = bench.add_subcommand(
      "settle", "How fast exact fields are there once a dragged curve is let go of");
  settle->add_option("PROJECT", args->project, "Project file (.ecorche)")->required();
  settle->add_option("DRAGS", args->script, "Recorded drags (JSON; bench/drags has some)")
      ->required();
  settle->add_option("--tets", args->tets, "Size of the domain instead of the project's");
  addAnisotropic(*settle, args->anisotropic);
  settle->add_option("--places", args->places, "Let go at so many places of each drag")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  settle->footer(
      "Example:\n"
      "  ecorche bench settle examples/dog/left-39.ecorche bench/drags/left-39.json --tets 640k");
  commands.push_back({settle, [args](Session& s) { return runSettle(*args, s); }});
}

}  // namespace ecorche::cli
