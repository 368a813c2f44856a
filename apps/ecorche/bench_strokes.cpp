#include <ecorche/core/parallel.h>
#include <ecorche/engine/stroke_bench.h>
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <memory>

#include "bench.h"
#include "table.h"

namespace ecorche::cli {

namespace {

using engine::CurveFit;
using engine::StrokeCase;
using Json = nlohmann::ordered_json;

struct StrokeArguments {
  std::string folder;
  engine::StrokeBenchOptions options;
  bool others = false;
  std::string output;
};

// Cases that have something in common
struct Summary {
  std::size_t strokes = 0;
  double paper = 0.0, bent = 0.0, ours = 0.0;                 // mean distance [m]
  double paperRel = 0.0, bentRel = 0.0, oursRel = 0.0;        // over the muscle's length
  double paperBack = 0.0, bentBack = 0.0, oursBack = 0.0;     // of the centreline to the curve [m]
  double paperWorst = 0.0, bentWorst = 0.0, oursWorst = 0.0;  // largest mean of one stroke [m]
  std::size_t paperLeaves = 0, bentLeaves = 0, oursLeaves = 0;
  std::size_t better = 0;  // than the paper's
};

template <class Takes>
Summary summaryOf(const std::vector<StrokeCase>& cases, const Takes& takes) {
  Summary out;
  for (const StrokeCase& c : cases) {
    if (!takes(c)) continue;
    ++out.strokes;
    const auto add = [&](const CurveFit& fit, double& mean, double& rel, double& back,
                         double& worst, std::size_t& leaves) {
      mean += fit.distance;
      rel += fit.distance / c.length;
      back += fit.back;
      worst = std::max(worst, fit.distance);
      leaves += fit.leaves ? 1 : 0;
    };
    add(c.paper, out.paper, out.paperRel, out.paperBack, out.paperWorst, out.paperLeaves);
    add(c.bent, out.bent, out.bentRel, out.bentBack, out.bentWorst, out.bentLeaves);
    add(c.ours, out.ours, out.oursRel, out.oursBack, out.oursWorst, out.oursLeaves);
    out.better += c.ours.distance < c.paper.distance ? 1 : 0;
  }
  const double count = static_cast<double>(std::max<std::size_t>(1, out.strokes));
  for (double* sum : {&out.paper, &out.bent, &out.ours, &out.paperRel, &out.bentRel, &out.oursRel,
                      &out.paperBack, &out.bentBack, &out.oursBack})
    *sum /= count;
  return out;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values);
  return values[static_cast<std::size_t>(std::ceil(q * static_cast<double>(values.size() - 1)))];
}

Json jsonOf(const Summary& s) {
  const auto part = [](double mean, double rel, double back, double worst, std::size_t leaves) {
    return Json{{"distance_mm", 1e3 * mean},
                {"distance_of_length", rel},
                {"back_mm", 1e3 * back},
                {"worst_mm", 1e3 * worst},
                {"curves_leaving", leaves}};
  };
  return {{"strokes", s.strokes},
          {"paper", part(s.paper, s.paperRel, s.paperBack, s.paperWorst, s.paperLeaves)},
          {"bent", part(s.bent, s.bentRel, s.bentBack, s.bentWorst, s.bentLeaves)},
          {"ours", part(s.ours, s.oursRel, s.oursBack, s.oursWorst, s.oursLeaves)},
          {"better", s.better}};
}

Result<void> runStrokes(const StrokeArguments& args, Session& session) {
  const auto atlas = engine::readStrokeAtlas(args.folder, session.run);
  if (!atlas) return passOn(atlas);
  engine::StrokeBenchOptions options = args.options;
  if (args.others) options.set = engine::StrokeSet::Others;
  const auto bench = engine::benchStrokes(*atlas, options, session.run);
  if (!bench) return passOn(bench);

  Table table({{"seen from", Table::Align::Left},
               {"strokes", Table::Align::Right},
               {"paper mm", Table::Align::Right},
               {"bent mm", Table::Align::Right},
               {"ours mm", Table::Align::Right},
               {"ours/paper", Table::Align::Right},
               {"of length", Table::Align::Right},
               {"nearer", Table::Align::Right},
               {"worst mm", Table::Align::Right},
               {"leave: paper", Table::Align::Right},
               {"bent", Table::Align::Right},
               {"ours", Table::Align::Right}});
  Json json = benchHeader("strokes");
  const auto add = [&](const std::string& name, const Summary& s) {
    if (s.strokes == 0) return;
    table.add({name, fmt::format("{}", s.strokes), fmt::format("{:.2f}", 1e3 * s.paper),
               fmt::format("{:.2f}", 1e3 * s.bent), fmt::format("{:.2f}", 1e3 * s.ours),
               fmt::format("{:.3f}", s.ours / s.paper),
               fmt::format("{:.3f}", s.oursRel / s.paperRel), fmt::format("{}", s.better),
               fmt::format("{:.1f}", 1e3 * s.oursWorst), fmt::format("{}", s.paperLeaves),
               fmt::format("{}", s.bentLeaves), fmt::format("{}", s.oursLeaves)});
  };
  const auto all = [](const StrokeCase&) { return true; };
  const Summary whole = summaryOf(bench->cases, all);
  std::map<std::string, int> views;
  for (const StrokeCase& c : bench->cases) ++views[c.view];
  for (const auto& [view, count] : views)
    add(view, summaryOf(bench->cases, [&](const StrokeCase& c) { return c.view == view; }));
  add("both ends seen", summaryOf(bench->cases, [](const StrokeCase& c) { return c.hidden == 0; }));
  add("an end hidden", summaryOf(bench->cases, [](const StrokeCase& c) { return c.hidden > 0; }));
  add("all", whole);

  std::vector<double> seconds;
  for (const StrokeCase& c : bench->cases) seconds.push_back(c.seconds);
  json["cases"].push_back({{"name", "all"},
                           {"muscles", bench->cases.size() / 3},
                           {"threads", threadCount()},
                           {"metrics",
                            {{"p50_ms", 1e3 * quantile(seconds, 0.5)},
                             {"p95_ms", 1e3 * quantile(seconds, 0.95)},
                             {"max_ms", 1e3 * quantile(seconds, 1.0)},
                             {"summary", jsonOf(whole)},
                             {"left_out", atlas->leftOut}}},
                           {"ratios", {{"distance_vs_paper", whole.ours / whole.paper}}},
                           {"errors", {{"curves_leaving", whole.oursLeaves}}}});
  for (const StrokeCase& c : bench->cases) {
    const auto fit = [](const CurveFit& f) {
      return Json{{"distance_mm", 1e3 * f.distance},
                  {"back_mm", 1e3 * f.back},
                  {"farthest_mm", 1e3 * f.farthest},
                  {"leaves", f.leaves},
                  {"points", f.points}};
    };
    json["cases"].push_back(
        {{"name", c.muscle + " " + c.view},
         {"metrics",
          {{"from", c.from},
           {"to", c.to},
           {"hidden_ends", c.hidden},
           {"length_mm", 1e3 * c.length},
           {"paper", fit(c.paper)},
           {"bent", fit(c.bent)},
           {"ours", fit(c.ours)},
           {"total_ms", 1e3 * c.seconds}}},
         {"ratios", {{"distance_vs_paper", c.ours.distance / c.paper.distance}}}});
  }
  if (!args.output.empty()) {
    std::ofstream file(args.output);
    file << json.dump(2) << '\n';
    if (!file.flush())
      return fail(ErrorCode::FileNotWritable, "this file cannot be written", {.file = args.output});
  }
  if (session.globals.json) {
    fmt::print("{}\n", json.dump(2));
    return {};
  }
  fmt::print(
      "{} muscles, {} strokes; a stroke takes {:.0f} ms (p95 {:.0f}, at most {:.0f})\n\n{}\n"
      "mm: distance of the curve to the muscle's centreline, mean of all strokes; paper: depth "
      "linear; bent: that, out of bones and skin\n",
      bench->cases.size() / 3, bench->cases.size(), 1e3 * quantile(seconds, 0.5),
      1e3 * quantile(seconds, 0.95), 1e3 * quantile(seconds, 1.0), table.text());
  return {};
}

}  // namespace

void addBenchStrokes(CLI::App& bench, Commands& commands) {
  auto args = std::make_shared<StrokeArguments>();
  CLI::App* strokes = bench.add_subcommand(
      "strokes",
      "How near first curves come to real muscles drawn from three sides, the paper's "
      "depth beside");
  strokes
      ->add_option("FOLDER", args->folder,
                   "SKINbody.stl, bones/, muscles/, sites/ and attachment_sites.csv of one body")
      ->required();
  strokes->add_option("--muscles", args->options.muscles, "How many, of those with two attachments")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  strokes->add_option("--seed", args->options.seed, "Of the hand")->capture_default_str();
  strokes->add_flag("--fixed-views", args->options.fixedViews,
                    "Lateral and 45° to the front and back, whether ends are seen or not");
  strokes->add_flag("--others", args->others,
                    "The muscles that are not measured: habits were found with these");
  engine::StrokeBenchOptions& options = args->options;
  const auto habit = [&](const char* name, double& value) {
    strokes->add_option(name, value, "Habit (docs/algorithms/first_guess.md)")
        ->capture_default_str();
  };
  habit("--skin-weight", options.habits.skinWeight);
  habit("--from-bone", options.habits.fromBone);
  habit("--from-skin", options.habits.fromSkin);
  habit("--room-weight", options.habits.roomWeight);
  habit("--lean", options.habits.lean);
  strokes->add_option("-o,--output", args->output, "Also write every stroke's figures here (JSON)");
  strokes->footer("Example:\n  ecorche bench strokes ../shared/data/dog -o strokes.json");
  commands.push_back({strokes, [args](Session& s) { return runStrokes(*args, s); }});
}

}  // namespace ecorche::cli
