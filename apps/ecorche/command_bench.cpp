#include <ecorche/core/parallel.h>
#include <ecorche/engine/bench.h>
#include <ecorche/engine/machine.h>
#include <ecorche/engine/view_bench.h>
#include <ecorche/model/project_file.h>
#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "bench.h"
#include "cli.h"
#include "counts.h"
#include "table.h"

namespace ecorche::cli {

namespace {

using Json = nlohmann::ordered_json;

struct BenchArguments {
  std::string project;
  std::vector<std::string> tets{"120k", "300k", "640k", "1.5M"};
  std::vector<double> factors{1024.0, 1000.0};
  std::string size;  // of the domain that is scaled, or built
  std::string preview = "640k";
  bool unsized = false;
  engine::ViewBenchOptions view;
  std::string viewUp = "z";
  bool withoutPaper = false;
  bool sizedOnly = false;
};

std::string percent(double share) { return fmt::format("{:.2f} %", 100.0 * share); }

double muscleVolume(const std::vector<double>& volume,
                    const std::vector<tissue::CurveTissue>& tissues) {
  double sum = 0.0;
  for (std::size_t i = 0; i < tissues.size(); ++i) sum += tissues[i].filler ? 0.0 : volume[i + 1];
  return sum;
}

// Muscles by how far their volume spreads, the farthest first
std::string spreadText(const engine::ResolutionBench& bench, std::size_t most) {
  struct Row {
    double change;
    std::size_t tissue;
  };
  std::vector<Row> rows;
  for (std::size_t i = 0; i < bench.tissues.size(); ++i) {
    if (bench.tissues[i].filler) continue;
    double least = std::numeric_limits<double>::infinity();
    double largest = 0.0;
    for (const auto& c : bench.cases) {
      least = std::min(least, c.volume[i + 1]);
      largest = std::max(largest, c.volume[i + 1]);
    }
    rows.push_back({largest / least - 1.0, i});
  }
  std::ranges::sort(rows, std::greater<>{}, &Row::change);
  std::vector<Table::Column> columns{{"muscle", Table::Align::Left}};
  for (const auto& c : bench.cases)
    columns.push_back({fmt::format("{} k", c.tets / 1000), Table::Align::Right});
  columns.push_back({"spread", Table::Align::Right});
  Table table(std::move(columns));
  for (std::size_t r = 0; r < std::min(most, rows.size()); ++r) {
    std::vector<std::string> cells{bench.tissues[rows[r].tissue].name};
    for (const auto& c : bench.cases)
      cells.push_back(fmt::format("{:.2f}", 1e6 * c.volume[rows[r].tissue + 1]));
    cells.push_back(percent(rows[r].change));
    table.add(std::move(cells));
  }
  return table.text();
}

Json volumesJson(const std::vector<double>& volume,
                 const std::vector<tissue::CurveTissue>& tissues) {
  Json out = Json::object();
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    if (!tissues[i].filler) out[tissues[i].name] = 1e6 * volume[i + 1];
  }
  return out;
}

Json resolutionJson(const engine::ResolutionBench& bench, const char* name) {
  Json out = benchHeader(name);
  const auto& finest = bench.cases.back();
  const auto change = [&](const std::vector<double>& now, const std::vector<double>& reference) {
    return muscleVolume(now, bench.tissues) / muscleVolume(reference, bench.tissues) - 1.0;
  };
  for (const auto& c : bench.cases) {
    out["cases"].push_back(
        {{"name", fmt::format("{} tets", c.tets)},
         {"tets", c.tets},
         {"muscles", bench.tissues.size()},
         {"threads", threadCount()},
         {"metrics",
          {{"free_vertices", c.freeVertices},
           {"total_ms", 1e3 * c.seconds},
           {"muscle_cm3", 1e6 * muscleVolume(c.volume, bench.tissues)},
           {"muscle_cm3_paper", 1e6 * muscleVolume(c.volumePaper, bench.tissues)},
           {"muscles_cm3", volumesJson(c.volume, bench.tissues)}}},
         {"ratios", Json::object()},
         {"errors",
          {{"volume_change", change(c.volume, finest.volume)},
           {"volume_change_paper", change(c.volumePaper, finest.volumePaper)}}}});
  }
  out["cases"].push_back({{"name", "spread over all"},
                          {"tets", finest.tets},
                          {"muscles", bench.tissues.size()},
                          {"threads", threadCount()},
                          {"metrics", {{"muscle", bench.tissues[bench.ours.tissue].name}}},
                          {"ratios", Json::object()},
                          {"errors",
                           {{"volume_change", bench.ours.total},
                            {"volume_change_paper", bench.paper.total},
                            {"volume_change_muscle", bench.ours.largest},
                            {"volume_change_muscle_paper", bench.paper.largest}}}});
  return out;
}

std::string resolutionText(const engine::ResolutionBench& bench) {
  Table table({{"tets", Table::Align::Right},
               {"free vertices", Table::Align::Right},
               {"muscles cm³", Table::Align::Right},
               {"paper, α = 5", Table::Align::Right},
               {"fields s", Table::Align::Right}});
  for (const auto& c : bench.cases) {
    table.add({fmt::format("{}", c.tets), fmt::format("{}", c.freeVertices),
               fmt::format("{:.1f}", 1e6 * muscleVolume(c.volume, bench.tissues)),
               fmt::format("{:.1f}", 1e6 * muscleVolume(c.volumePaper, bench.tissues)),
               fmt::format("{:.2f}", c.seconds)});
  }
  return table.text() + "\nmuscles whose volume changes most, cm³\n" + spreadText(bench, 8) +
         fmt::format(
             "\nlargest over smallest: muscles together {} (paper's rows {}), any muscle above "
             "5 cm³ {} ({}; paper's rows {}, {})\n",
             percent(bench.ours.total), percent(bench.paper.total), percent(bench.ours.largest),
             bench.tissues[bench.ours.tissue].name, percent(bench.paper.largest),
             bench.tissues[bench.paper.tissue].name);
}

Result<void> runResolution(const BenchArguments& args, Session& session) {
  const auto tets = parseCounts(args.tets);
  if (!tets) return passOn(tets);
  auto project = model::loadProject(args.project);
  if (!project) return passOn(project);
  auto bench = engine::benchResolution(*project, *tets, session.run);
  if (!bench) return passOn(bench);
  fmt::print("{}", session.globals.json ? resolutionJson(*bench, "resolution").dump(2) + "\n"
                                        : resolutionText(*bench));
  return {};
}

Result<void> runPreview(const BenchArguments& args, Session& session) {
  const auto preview = parseCount(args.preview);
  if (!preview) return passOn(preview);
  const auto tets = parseCountIfAny(args.size);
  if (!tets) return passOn(tets);
  auto project = model::loadProject(args.project);
  if (!project) return passOn(project);
  const auto sizing = args.unsized ? engine::Sizing::None : engine::Sizing::Curves;
  auto bench = engine::benchPreview(*project, *preview, sizing, *tets, session.run);
  if (!bench) return passOn(bench);
  fmt::print("{}", session.globals.json ? resolutionJson(*bench, "preview").dump(2) + "\n"
                                        : resolutionText(*bench));
  return {};
}

Result<void> runScale(const BenchArguments& args, Session& session) {
  const auto tets = parseCountIfAny(args.size);
  if (!tets) return passOn(tets);
  auto project = model::loadProject(args.project);
  if (!project) return passOn(project);
  auto cases = engine::benchScale(*project, args.factors, *tets, session.run);
  if (!cases) return passOn(cases);
  const auto tissues = engine::curveTissues(*project);
  Json json = benchHeader("scale");
  Table table({{"factor", Table::Align::Right},
               {"tets", Table::Align::Right},
               {"same tets", Table::Align::Left},
               {"volume shares", Table::Align::Right},
               {"muscles together", Table::Align::Right},
               {"any above 5 cm³", Table::Align::Right},
               {"", Table::Align::Left}});
  for (const engine::ScaleCase& c : *cases) {
    json["cases"].push_back({{"name", fmt::format("times {}", c.factor)},
                             {"tets", c.tets},
                             {"muscles", tissues.size()},
                             {"threads", threadCount()},
                             {"metrics", {{"same_tets", c.sameTets}}},
                             {"ratios", Json::object()},
                             {"errors",
                              {{"share_change", c.shareChange},
                               {"volume_change", c.totalChange},
                               {"volume_change_muscle", c.largestChange}}}});
    table.add({fmt::format("{}", c.factor), fmt::format("{}", c.tets), c.sameTets ? "yes" : "no",
               fmt::format("{:.2g}", c.shareChange), percent(c.totalChange),
               percent(c.largestChange), tissues[c.tissue].name});
  }
  fmt::print("{}", session.globals.json ? json.dump(2) + "\n" : table.text());
  return {};
}

Json viewJson(const std::vector<engine::ViewCase>& cases, const engine::ViewBenchOptions& options) {
  Json out = benchHeader("view");
  const auto frame = [](const engine::FrameTimes& t) {
    return Json{{"p50_ms", 1e3 * t.p50},
                {"p95_ms", 1e3 * t.p95},
                {"max_ms", 1e3 * t.max},
                {"processor_ms", 1e3 * t.processor}};
  };
  for (const engine::ViewCase& c : cases) {
    Json metrics = frame(c.frame);
    metrics["steps"] = frame(c.steps);
    metrics["width"] = options.width;
    metrics["height"] = options.height;
    metrics["drawn_tets"] = c.drawnTets;
    metrics["triangles"] = c.triangles;
    metrics["prepare_ms"] = 1e3 * c.prepare;
    metrics["first_upload_ms"] = 1e3 * c.firstUpload;
    metrics["full_bytes"] = c.fullBytes;
    metrics["edit_vertex_share"] = c.editShare;
    metrics["edit_bytes"] = c.editBytes;
    metrics["edit_upload_ms"] = 1e3 * c.editUpload;
    metrics["pick_ms"] = 1e3 * c.pick;
    metrics["same_tissue_share"] = c.sameTissue;
    metrics["normals_within_3_deg_share"] = c.normalsClose;
    Json ratios = Json::object();
    if (c.paper.p50 > 0.0) {
      metrics["draw_all"] = frame(c.paper);
      metrics["draw_all_same_tissue_share"] = c.paperSameTissue;
      ratios["vs_draw_all"] = c.paper.p50 / c.steps.p50;
      ratios["vs_draw_all_processor"] = c.paper.processor / c.steps.processor;
      ratios["vs_draw_all_whole_frame"] = c.paper.p50 / c.frame.p50;
    }
    out["cases"].push_back({{"name", c.name},
                            {"tets", c.tets},
                            {"muscles", c.muscles},
                            {"threads", threadCount()},
                            {"metrics", metrics},
                            {"ratios", ratios},
                            {"errors", {{"owner_share", 1.0 - c.sameTissue}}}});
  }
  return out;
}

std::string viewText(const std::vector<engine::ViewCase>& cases) {
  Table table({{"domain", Table::Align::Left},
               {"tets", Table::Align::Right},
               {"drawn", Table::Align::Right},
               {"frame ms", Table::Align::Right},
               {"muscles ms", Table::Align::Right},
               {"paper's ms", Table::Align::Right},
               {"times", Table::Align::Right},
               {"same tissue", Table::Align::Right},
               {"normals", Table::Align::Right},
               {"edit", Table::Align::Right},
               {"sent", Table::Align::Right},
               {"pick ms", Table::Align::Right}});
  for (const engine::ViewCase& c : cases)
    table.add({c.name, fmt::format("{}", c.tets), fmt::format("{}", c.drawnTets),
               fmt::format("{:.1f}", 1e3 * c.frame.p50), fmt::format("{:.1f}", 1e3 * c.steps.p50),
               fmt::format("{:.0f}", 1e3 * c.paper.p50),
               fmt::format("{:.1f}", c.paper.p50 / c.steps.p50), percent(c.sameTissue),
               percent(c.normalsClose), percent(c.editShare),
               percent(static_cast<double>(c.editBytes) / static_cast<double>(c.fullBytes)),
               fmt::format("{:.2f}", 1e3 * c.pick)});
  return table.text() +
         "\nframe: bones, muscles and skin, lit, read back; muscles: the step from fat alone, "
         "against "
         "the paper's way\nedit: share of vertices that a moved curve changed; sent: share of all "
         "bytes that went to the card for it\n";
}

Result<void> runView(BenchArguments args, Session& session) {
  const auto tets = parseCountIfAny(args.size);
  if (!tets) return passOn(tets);
  auto project = model::loadProject(args.project);
  if (!project) return passOn(project);
  args.view.tets = *tets;
  args.view.paper = !args.withoutPaper;
  args.view.uniform = !args.sizedOnly;
  args.view.up = static_cast<char>(std::toupper(args.viewUp.front()));
  auto cases = engine::benchView(*project, args.view, session.run);
  if (!cases) return passOn(cases);
  fmt::print("{}",
             session.globals.json ? viewJson(*cases, args.view).dump(2) + "\n" : viewText(*cases));
  return {};
}

}  // namespace

nlohmann::ordered_json benchHeader(const char* bench) {
  const exchange::MachineFigures machine = engine::thisMachine();
  return {{"bench", bench},
          {"machine",
           {{"processor", machine.processor},
            {"cores", machine.cores},
            {"threads", machine.threads},
            {"blas", machine.blas}}},
          {"cases", Json::array()}};
}

void addBench(CLI::App& app, Commands& commands) {
  auto args = std::make_shared<BenchArguments>();
  CLI::App* bench = app.add_subcommand("bench", "Measure what the program promises");
  bench->require_subcommand(1);
  CLI::App* resolution = bench->add_subcommand(
      "resolution",
      "How much muscle volumes change with the number of tets, the paper's rows beside");
  resolution->add_option("PROJECT", args->project, "Project file (.ecorche)")->required();
  resolution
      ->add_option("--tets", args->tets, "Sizes of the domain, coarse to fine, comma-separated")
      ->delimiter(',')
      ->expected(2, 20)
      ->capture_default_str();
  CLI::App* preview = bench->add_subcommand(
      "preview", "How much muscles differ between the domain of previews and that of builds");
  preview->add_option("PROJECT", args->project, "Project file (.ecorche)")->required();
  preview
      ->add_option("--preview", args->preview,
                   "Size of the preview's domain, which knows curves but not muscles")
      ->capture_default_str();
  preview->add_flag("--unsized", args->unsized,
                    "The preview's domain does not know the curves either");
  preview->add_option("--tets", args->size, "Size of the build's domain instead of the project's");
  CLI::App* scale = bench->add_subcommand(
      "scale", "How much volumes change when everything is multiplied by a factor");
  scale->add_option("PROJECT", args->project, "Project file (.ecorche)")->required();
  scale->add_option("--factors", args->factors, "Factors, comma-separated")
      ->delimiter(',')
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  scale->add_option("--tets", args->size, "Size of the domain instead of the project's");
  CLI::App* view = bench->add_subcommand(
      "view", "How fast and how right the preview is drawn, the paper's way beside");
  view->add_option("PROJECT", args->project, "Project file (.ecorche)")->required();
  view->add_option("--tets", args->size, "Size of the domain instead of the project's");
  view->add_option("--frames", args->view.frames, "Frames while the view turns once around")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  view->add_option("--up", args->viewUp, "Axis that points up: x, y or z")
      ->check(CLI::IsMember({"x", "y", "z", "X", "Y", "Z"}))
      ->capture_default_str();
  view->add_flag("--sized-only", args->sizedOnly,
                 "Leave out the domain that does not know the muscles; not every project has one");
  view->add_flag("--without-paper", args->withoutPaper, "Leave the paper's way out");
  bench->footer(
      "Examples:\n"
      "  ecorche bench adaptive left-39.ecorche --tets 80k,160k,320k,640k --reference 4M\n"
      "  ecorche bench drag left-39.ecorche bench/drags/left-39.json --tets 640k\n"
      "  ecorche bench resolution hind-limb.ecorche --tets 120k,640k,1.5M\n"
      "  ecorche bench preview hind-limb.ecorche --preview 640k --tets 640k\n"
      "  ecorche bench scale hind-limb.ecorche --tets 640k --json\n"
      "  ecorche bench strokes ../shared/data/dog\n"
      "  ecorche bench values left-39.ecorche --tets 640k\n"
      "  ecorche bench view hind-limb.ecorche --tets 640k --json");
  commands.push_back({resolution, [args](Session& s) { return runResolution(*args, s); }});
  commands.push_back({preview, [args](Session& s) { return runPreview(*args, s); }});
  commands.push_back({view, [args](Session& s) { return runView(*args, s); }});
  commands.push_back({scale, [args](Session& s) { return runScale(*args, s); }});
  addBenchAdaptive(*bench, commands);
  addBenchDrag(*bench, commands);
  addBenchSettle(*bench, commands);
  addBenchStrokes(*bench, commands);
  addBenchValues(*bench, commands);
}

}  // namespace ecorche::cli
