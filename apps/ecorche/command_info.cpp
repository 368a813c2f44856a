#include <ecorche/model/project_file.h>

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "cli.h"
#include "table.h"

namespace ecorche::cli {

namespace {

using namespace model;
using Json = nlohmann::ordered_json;

/// What the table and the JSON both tell of a tissue.
struct TissueFacts {
  std::int32_t id = 0;
  std::size_t points = 0;
  double length = 0.0;  // of all curves [m]
  double thinnest = 0.0, thickest = 0.0;
};

TissueFacts factsOf(const Project& project, std::size_t index) {
  const Tissue& tissue = project.tissues[index];
  TissueFacts facts{.id = tissueId(project, index).value};
  for (const Curve& curve : tissue.curves) {
    facts.length += splineOf(curve).length();
    for (const ControlPoint& p : curve.points) {
      facts.thinnest = facts.points == 0 ? p.tissue : std::min(facts.thinnest, p.tissue);
      facts.thickest = std::max(facts.thickest, p.tissue);
      ++facts.points;
    }
  }
  return facts;
}

std::vector<std::string> missingFiles(const Project& project) {
  std::vector<std::string> missing;
  const auto look = [&](const MeshRef& mesh) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(meshPath(project, mesh), ignored)) return;
    if (std::ranges::find(missing, mesh.file) == missing.end()) missing.push_back(mesh.file);
  };
  look(project.skin);
  for (const Bone& bone : project.bones) look(bone.mesh);
  for (const Tissue& tissue : project.tissues) {
    if (tissue.mesh) look(*tissue.mesh);
    for (const Attachment& a : tissue.attachments) {
      if (a.patch) look(*a.patch);
    }
  }
  return missing;
}

Json toJson(const Support& support) {
  Json json = {{"on", word(support.on)}};
  if (!support.name.empty()) json["name"] = support.name;
  return json;
}

Json infoJson(const Project& project) {
  Json json;
  json["name"] = project.name;
  json["unit"] = symbol(project.unit);
  json["skin"] = meshPath(project, project.skin).string();
  for (const Bone& bone : project.bones) json["bones"].push_back(bone.name);
  for (const CutPlane& plane : project.cutPlanes) {
    const Vector3 &p = plane.point, &n = plane.normal;
    json["cut_planes"].push_back({{"name", plane.name},
                                  {"kind", word(plane.kind)},
                                  {"point_m", {p.x(), p.y(), p.z()}},
                                  {"normal", {n.x(), n.y(), n.z()}}});
  }
  for (std::size_t k = 0; k < project.tissues.size(); ++k) {
    const Tissue& tissue = project.tissues[k];
    const TissueFacts facts = factsOf(project, k);
    Json entry = {{"id", facts.id}, {"name", tissue.name}, {"kind", word(tissue.kind)}};
    if (tissue.side != Side::Unknown) entry["side"] = word(tissue.side);
    if (!tissue.group.empty()) entry["group"] = tissue.group;
    if (tissue.layer) entry["layer"] = *tissue.layer;
    for (const Curve& curve : tissue.curves) {
      entry["curves"].push_back({{"name", curve.name},
                                 {"points", curve.points.size()},
                                 {"length_m", splineOf(curve).length()},
                                 {"start", toJson(curve.start)},
                                 {"end", toJson(curve.end)}});
    }
    json["tissues"].push_back(std::move(entry));
  }
  json["missing_files"] = missingFiles(project);
  return json;
}

std::string describe(const Settings& s) {
  std::string text = fmt::format("fat {}", s.fat);
  if (s.coreRadius) text += fmt::format(", core radius {} mm", *s.coreRadius * 1e3);
  if (s.alpha) text += fmt::format(", alpha {}", *s.alpha);
  if (s.tets) text += fmt::format(", {} tets", *s.tets);
  if (s.edgeLength) text += fmt::format(", edges of {} mm", *s.edgeLength * 1e3);
  return text + fmt::format(", surface tolerance {} %", s.surfaceTolerance * 100);
}

std::string orDash(std::string_view text) { return text.empty() ? "-" : std::string(text); }

void printInfo(const Project& project, const std::string& file) {
  fmt::print("{}  ({}, unit {})\n", project.name.empty() ? "unnamed project" : project.name, file,
             symbol(project.unit));
  fmt::print("skin        {}\n", project.skin.file);
  fmt::print("bones       {}\n", project.bones.size());
  for (const CutPlane& plane : project.cutPlanes) {
    fmt::print(
        "cut plane   {} ({}) through {:.4g}, {:.4g}, {:.4g} m, keeps {:.3g}, {:.3g}, {:.3g}\n",
        plane.name, word(plane.kind), plane.point.x(), plane.point.y(), plane.point.z(),
        plane.normal.x(), plane.normal.y(), plane.normal.z());
  }
  fmt::print("settings    {}\n", describe(project.settings));

  if (!project.tissues.empty()) {
    using enum Table::Align;
    Table table({{"id", Right},
                 {"name"},
                 {"kind"},
                 {"side"},
                 {"group"},
                 {"curves", Right},
                 {"points", Right},
                 {"length [cm]", Right},
                 {"values", Right}});
    for (std::size_t k = 0; k < project.tissues.size(); ++k) {
      const Tissue& tissue = project.tissues[k];
      const TissueFacts facts = factsOf(project, k);
      std::string values = "-", id = "-", length = "-";
      if (facts.points > 0) {
        values = facts.thinnest == facts.thickest
                     ? fmt::format("{:.3g}", facts.thinnest)
                     : fmt::format("{:.3g}–{:.3g}", facts.thinnest, facts.thickest);
        length = fmt::format("{:.1f}", facts.length * 100);
      }
      if (facts.id > 0) id = std::to_string(facts.id);
      table.add({id, tissue.name, std::string(word(tissue.kind)), orDash(word(tissue.side)),
                 orDash(tissue.group), std::to_string(tissue.curves.size()),
                 std::to_string(facts.points), length, values});
    }
    fmt::print("\n{}", table.text());
  }
  const auto missing = missingFiles(project);
  constexpr std::size_t kShown = 6;
  if (!missing.empty()) fmt::print("\nnot found beside the project:\n");
  for (std::size_t k = 0; k < std::min(kShown, missing.size()); ++k)
    fmt::print("  {}\n", missing[k]);
  if (missing.size() > kShown)
    fmt::print("  and {} more (--json lists all)\n", missing.size() - kShown);
}

}  // namespace

void addInfo(CLI::App& app, Commands& commands) {
  CLI::App* const sub =
      app.add_subcommand("info", "What a project holds: bones, planes, settings, muscles");
  const auto file = std::make_shared<std::string>();
  sub->add_option("PROJECT", *file, "A project file (.ecorche)")->required();
  sub->footer(
      "Examples:\n  ecorche info arm.ecorche\n  ecorche info arm.ecorche --json | jq "
      "'.tissues[].name'");
  commands.push_back({sub, [file](Session& session) -> Result<void> {
                        const auto project = loadProject(*file);
                        if (!project) return passOn(project);
                        if (session.globals.json) {
                          fmt::print("{}\n", infoJson(*project).dump(2));
                        } else {
                          printInfo(*project, *file);
                        }
                        return {};
                      }});
}

}  // namespace ecorche::cli
