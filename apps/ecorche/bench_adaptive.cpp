#include <ecorche/core/parallel.h>
#include <ecorche/engine/bench_adaptive.h>
#include <ecorche/model/project_file.h>
#include <fmt/format.h>

#include <memory>

#include "bench.h"
#include "counts.h"
#include "table.h"

namespace ecorche::cli {

namespace {

struct AdaptiveArguments {
  std::string project;
  std::vector<std::string> tets{"80k", "160k", "320k", "640k", "1.3M"};
  std::string reference = "4M";
};

const char* kindOf(const engine::AdaptiveCase& c) {
  switch (c.sizing) {
    case engine::Sizing::None:
      return "uniform";
    case engine::Sizing::Curves:
      return "around curves";
    default:
      return "around muscles";
  }
}

Result<void> runAdaptive(const AdaptiveArguments& args, Session& session) {
  const auto project = model::loadProject(args.project);
  if (!project) return passOn(project);
  const auto reference = parseCount(args.reference);
  if (!reference) return passOn(reference);
  const auto tets = parseCounts(args.tets);
  if (!tets) return passOn(tets);
  const auto bench = engine::benchAdaptive(*project, *tets, *reference, session.run);
  if (!bench) return passOn(bench);
  auto json = benchHeader("adaptive");
  Table table({{"tets", Table::Align::Left},
               {"", Table::Align::Right},
               {"vertices", Table::Align::Right},
               {"mean mm", Table::Align::Right},
               {"rms mm", Table::Align::Right},
               {"p95 mm", Table::Align::Right},
               {"uniform takes", Table::Align::Right}});
  for (const engine::AdaptiveCase& c : bench->cases) {
    json["cases"].push_back({{"name", kindOf(c)},
                             {"tets", c.tets},
                             {"threads", threadCount()},
                             {"metrics", {{"vertices", c.vertices}}},
                             {"ratios", nlohmann::ordered_json::object()},
                             {"errors",
                              {{"mean_mm", 1e3 * c.error.mean},
                               {"rms_mm", 1e3 * c.error.rms},
                               {"p95_mm", 1e3 * c.error.p95}}}});
    if (c.saved) json["cases"].back()["ratios"]["uniform_tets_at_equal_error"] = *c.saved;
    table.add({kindOf(c), fmt::format("{}", c.tets), fmt::format("{}", c.vertices),
               fmt::format("{:.3f}", 1e3 * c.error.mean), fmt::format("{:.3f}", 1e3 * c.error.rms),
               fmt::format("{:.3f}", 1e3 * c.error.p95),
               c.saved ? fmt::format("{}{:.2f} times", c.savesMore ? "over " : "", *c.saved)
                       : std::string()});
  }
  if (session.globals.json) {
    fmt::print("{}\n", json.dump(2));
    return {};
  }
  fmt::print(
      "{}\nDistance of interfaces between tissues to those on {} tets, by area, both ways.\n"
      "Last column: tets of a uniform domain with the same mean error, over those at hand.\n",
      table.text(), bench->referenceTets);
  return {};
}

}  // namespace

void addBenchAdaptive(CLI::App& bench, Commands& commands) {
  auto args = std::make_shared<AdaptiveArguments>();
  CLI::App* adaptive = bench.add_subcommand(
      "adaptive", "How many tets small ones around muscles save, against a uniform domain");
  adaptive->add_option("PROJECT", args->project, "Project file (.ecorche)")->required();
  adaptive->add_option("--tets", args->tets, "Sizes of each kind of domain, comma-separated")
      ->delimiter(',')
      ->expected(2, 20)
      ->capture_default_str();
  adaptive
      ->add_option("--reference", args->reference, "Size of the domain that interfaces belong on")
      ->capture_default_str();
  commands.push_back({adaptive, [args](Session& s) { return runAdaptive(*args, s); }});
}

}  // namespace ecorche::cli
