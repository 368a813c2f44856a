#include <ecorche/core/parallel.h>
#include <ecorche/engine/bench_values.h>
#include <ecorche/model/project_file.h>
#include <fmt/format.h>

#include <memory>

#include "bench.h"
#include "counts.h"
#include "table.h"

namespace ecorche::cli {

namespace {

struct ValuesArguments {
  std::string project;
  std::string tets;
  int edits = 240;
};

nlohmann::ordered_json caseOf(const char* name, const engine::ValuesBench& bench,
                              const engine::Times& times) {
  const double baseline = bench.again.quantile(0.5);
  return {{"name", name},
          {"tets", bench.tets},
          {"muscles", bench.tissues},
          {"threads", threadCount()},
          {"metrics",
           {{"free_vertices", bench.freeVertices},
            {"p50_ms", 1e3 * times.quantile(0.5)},
            {"p95_ms", 1e3 * times.quantile(0.95)},
            {"max_ms", 1e3 * times.quantile(1.0)}}},
          {"ratios", {{"vs_cholmod_refactor", baseline / times.quantile(0.95)}}},
          {"errors", {{"field_rel", bench.fieldError}, {"owner_share", bench.ownerShare}}}};
}

Result<void> runValues(const ValuesArguments& args, Session& session) {
  const auto project = model::loadProject(args.project);
  if (!project) return passOn(project);
  const auto tets = parseCountIfAny(args.tets);
  if (!tets) return passOn(tets);
  const auto bench = engine::benchValues(*project, *tets, args.edits, session.run);
  if (!bench) return passOn(bench);
  auto json = benchHeader("values");
  Table table({{"act", Table::Align::Left},
               {"times", Table::Align::Right},
               {"p50 ms", Table::Align::Right},
               {"p95 ms", Table::Align::Right},
               {"max ms", Table::Align::Right},
               {"faster than solving again", Table::Align::Right}});
  const auto add = [&](const char* name, const engine::Times& times) {
    json["cases"].push_back(caseOf(name, *bench, times));
    table.add({name, fmt::format("{}", times.seconds.size()),
               fmt::format("{:.2f}", 1e3 * times.quantile(0.5)),
               fmt::format("{:.2f}", 1e3 * times.quantile(0.95)),
               fmt::format("{:.2f}", 1e3 * times.quantile(1.0)),
               fmt::format("{:.0f} times", bench->again.quantile(0.5) / times.quantile(0.95))});
  };
  add("tissue value", bench->value);
  add("fat", bench->fat);
  add("all values by one factor", bench->whole);
  add("first edit of a muscle", bench->touch);
  add("first edit of another point", bench->point);
  add("factor and solve again", bench->again);
  if (session.globals.json) {
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print(
        "{} tets, {} free vertices, {} tissues\n\n{}\nAgainst a solve from scratch: fields "
        "{:.1e} of the largest value, {:.4f} % of the owners other\n",
        bench->tets, bench->freeVertices, bench->tissues, table.text(), bench->fieldError,
        100.0 * bench->ownerShare);
  }
  return {};
}

}  // namespace

void addBenchValues(CLI::App& bench, Commands& commands) {
  auto args = std::make_shared<ValuesArguments>();
  CLI::App* values = bench.add_subcommand(
      "values", "How fast tissue values and fat answer, against solving again");
  values->add_option("PROJECT", args->project, "Project file (.ecorche)")->required();
  values->add_option("--tets", args->tets, "Size of the domain instead of the project's");
  values->add_option("--edits", args->edits, "How many values are changed")
      ->check(CLI::Range(12, 100000))
      ->capture_default_str();
  values->footer("Example:\n  ecorche bench values examples/dog/left-39.ecorche --tets 640k");
  commands.push_back({values, [args](Session& s) { return runValues(*args, s); }});
}

}  // namespace ecorche::cli
