#include <ecorche/engine/output.h>
#include <ecorche/exchange/check_anatomy.h>
#include <ecorche/model/project_file.h>
#include <fmt/format.h>

#include <memory>

#include "cli.h"
#include "counts.h"

namespace ecorche::cli {

namespace {

struct BuildArguments {
  std::string project;
  std::string output;
  std::string tets;
  std::string formats = "vtu,mesh,obj";
  std::optional<double> edge;
  std::optional<double> alpha;
  double mesherTimeout = engine::BuildOptions{}.mesherTimeout;
  bool noCache = false;
  bool exact = false;
  bool noPreview = false;
};

Result<void> runBuild(const BuildArguments& args, Session& session) {
  auto formats = exchange::parseFormats(args.formats);
  if (!formats) return passOn(formats);
  engine::BuildOptions options{.edgeLength = args.edge,
                               .alpha = args.alpha,
                               .mesherTimeout = args.mesherTimeout,
                               .useCache = !args.noCache,
                               .exact = args.exact};
  const auto tets = parseCountIfAny(args.tets);
  if (!tets) return passOn(tets);
  options.tets = *tets;
  options.onEstimate = [&](const engine::Estimate& estimate) {
    if (!session.globals.quiet) fmt::print(stderr, "estimate: {}\n", estimate.text());
  };
  auto project = model::loadProject(args.project);
  if (!project) return passOn(project);
  // Minutes of work should not end at a folder that cannot be written
  if (auto writable = engine::stageOutput(args.output); !writable) return passOn(writable);

  auto build = engine::build(*project, options, session.run);
  if (!build) {
    Error error = build.error();
    if (error.place.file.empty()) error.place.file = args.project;
    return tl::unexpected(std::move(error));
  }
  auto report = engine::writeBuild(*project, *build, args.output,
                                   {.formats = *formats, .preview = !args.noPreview}, session.run);
  if (!report) return passOn(report);

  if (session.globals.json) {
    fmt::print("{}", exchange::printReport(*report));
  } else {
    fmt::print("{}\nWritten to {}\n", exchange::reportTable(*report), args.output);
  }
  for (const exchange::Check& check : report->checks) {
    if (!check.pass) {
      fmt::print(stderr, "ecorche: warning: check {} failed{}: {}\n", check.name,
                 check.object.empty() ? "" : " for " + check.object, check.detail);
    }
  }
  return {};
}

}  // namespace

void addBuild(CLI::App& app, Commands& commands) {
  auto args = std::make_shared<BuildArguments>();
  CLI::App* sub = app.add_subcommand(
      "build", "Make the anatomy of a project: labelled tets, surfaces, fibres, report");
  sub->add_option("PROJECT", args->project, "Project file (.ecorche)")->required();
  sub->add_option("-o,--output", args->output, "Folder to write; it appears whole or not at all")
      ->required();
  sub->add_option("--tets", args->tets,
                  "About how many tets the domain gets: 200k, 1.3M … (default: the project's)");
  sub->add_option("--edge", args->edge, "Mean edge length of tets instead [m]")
      ->check(CLI::PositiveNumber)
      ->excludes("--tets");
  sub->add_option("--formats", args->formats, "Comma-separated: vtu, mesh, obj")
      ->capture_default_str();
  sub->add_option("--alpha", args->alpha,
                  "Weigh curves as the paper does, by this constant; for comparison")
      ->check(CLI::PositiveNumber);
  sub->add_option("--mesher-timeout", args->mesherTimeout,
                  "How long a mesher may take before it is stopped [s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  sub->add_flag("--no-cache", args->noCache,
                "Do not look for the domain in the cache nor leave it there");
  sub->add_flag("--exact", args->exact,
                "Keep raw places of new vertices; tets without volume are counted, not repaired");
  sub->add_flag("--no-preview", args->noPreview, "Leave out preview.png");
  sub->footer(
      "Examples:\n"
      "  ecorche build arm.ecorche -o out\n"
      "  ecorche build hind-limb.ecorche -o out --tets 640k --formats vtu,obj\n"
      "Writes anatomy.vtu, anatomy.mesh, muscles/NAME.obj, bones/NAME.obj, fat.obj, skin.obj, "
      "model.json,\n"
      "report.json and preview.png. `ecorche check DIR` proves what they claim.");
  commands.push_back({sub, [args](Session& session) { return runBuild(*args, session); }});
}

}  // namespace ecorche::cli
