#include <ecorche/core/parallel.h>
#include <ecorche/engine/bench_drag.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "bench.h"
#include "recorded_drags.h"
#include "table.h"

namespace ecorche::cli {

namespace {

struct DragArguments {
  std::string project;
  std::string script;
  std::string tets;
  int anisotropic = 0;
  int checked = 20;
  bool withoutSimplicial = false;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return values[values.size() / 2];
}

Result<void> runDrag(const DragArguments& args, Session& session) {
  const auto given = loadRecordedDrags(args.project, args.script, args.tets, args.anisotropic);
  if (!given) return passOn(given);
  const auto bench = engine::benchDrag(given->project, given->tets, given->scripts, args.checked,
                                       !args.withoutSimplicial, session.run);
  if (!bench) return passOn(bench);

  auto json = benchHeader("drag");
  Table table({{"drag", Table::Align::Left},
               {"p50 ms", Table::Align::Right},
               {"p95 ms", Table::Align::Right},
               {"max ms", Table::Align::Right},
               {"start ms", Table::Align::Right},
               {"solving again ms", Table::Align::Right},
               {"faster", Table::Align::Right},
               {"fields off, %", Table::Align::Right},
               {"median", Table::Align::Right},
               {"owners off, %", Table::Align::Right},
               {"written, %", Table::Align::Right},
               {"checked", Table::Align::Right}});
  for (const engine::DragRun& drag : bench->runs) {
    const double p95 = drag.frame.quantile(0.95);
    const double again = drag.again.quantile(0.5);
    nlohmann::ordered_json ratios = {{"vs_cholmod_refactor", again / p95}};
    if (bench->simplicial) ratios["vs_simplicial_ldlt"] = *bench->simplicial / p95;
    json["cases"].push_back(
        {{"name", drag.name},
         {"tets", bench->tets},
         {"muscles", bench->tissues},
         {"threads", threadCount()},
         {"metrics",
          {{"free_vertices", bench->freeVertices},
           {"p50_ms", 1e3 * drag.frame.quantile(0.5)},
           {"p95_ms", 1e3 * p95},
           {"max_ms", 1e3 * drag.frame.quantile(1.0)},
           {"start_ms", 1e3 * drag.begin},
           {"cholmod_refactor_ms", 1e3 * again},
           {"frames_checked", drag.fieldError.size()},
           {"frames_outside", drag.unchecked}}},
         {"ratios", ratios},
         {"errors",
          {{"field_rel", largest(drag.fieldError)}, {"owner_share", largest(drag.ownerShare)}}}});
    table.add({drag.name, fmt::format("{:.1f}", 1e3 * drag.frame.quantile(0.5)),
               fmt::format("{:.1f}", 1e3 * p95),
               fmt::format("{:.1f}", 1e3 * drag.frame.quantile(1.0)),
               fmt::format("{:.0f}", 1e3 * drag.begin), fmt::format("{:.0f}", 1e3 * again),
               fmt::format("{:.0f} times", again / p95),
               fmt::format("{:.2f}", 100.0 * largest(drag.fieldError)),
               fmt::format("{:.2f}", 100.0 * median(drag.fieldError)),
               fmt::format("{:.3f}", 100.0 * largest(drag.ownerShare)),
               fmt::format("{:.1f}", 100.0 * median(drag.changedShare)),
               fmt::format("{} of {}", drag.fieldError.size(),
                           drag.fieldError.size() + static_cast<std::size_t>(drag.unchecked))});
  }
  if (session.globals.json) {
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{} tets, {} free vertices, {} tissues\n", bench->tets, bench->freeVertices,
               bench->tissues);
    if (bench->simplicial)
      fmt::print("Eigen's SimplicialLDLT, factor and all fields: {:.1f} s\n", *bench->simplicial);
    fmt::print("\n{}", table.text());
  }
  return {};
}

}  // namespace

void addBenchDrag(CLI::App& bench, Commands& commands) {
  auto args = std::make_shared<DragArguments>();
  CLI::App* drag =
      bench.add_subcommand("drag", "How fast and how right fields follow a dragged curve");
  drag->add_option("PROJECT", args->project, "Project file (.ecorche)")->required();
  drag->add_option("DRAGS", args->script, "Recorded drags (JSON; bench/drags has some)")
      ->required();
  drag->add_option("--tets", args->tets, "Size of the domain instead of the project's");
  addAnisotropic(*drag, args->anisotropic);
  drag->add_option("--check-every", args->checked,
                   "Compare every so many frames with solving again")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  drag->add_flag("--without-simplicial", args->withoutSimplicial,
                 "Leave out Eigen's SimplicialLDLT, which takes long");
  drag->footer(
      "Example:\n"
      "  ecorche bench drag examples/dog/left-39.ecorche bench/drags/left-39.json --tets 640k");
  commands.push_back({drag, [args](Session& s) { return runDrag(*args, s); }});
}

}  // namespace ecorche::cli
