#include <ecorche/engine/import_check.h>
#include <ecorche/engine/inputs.h>
#include <ecorche/exchange/check_anatomy.h>
#include <ecorche/exchange/report.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/model/project_file.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "cli.h"
#include "table.h"

namespace ecorche::cli {

namespace {

using Json = nlohmann::ordered_json;

Result<void> checkFolder(const std::string& folder, Session& session) {
  auto report = exchange::checkOutput(folder, session.run);
  if (!report) return passOn(report);
  if (session.globals.json) {
    fmt::print("{}", exchange::printCheckReport(*report));
    session.answered = true;
  } else {
    fmt::print("{}\n{} tets, {} vertices, {} checks, {}\n", exchange::checkTable(report->checks),
               report->tets, report->vertices, report->checks.size(),
               report->pass() ? "all passed" : "NOT all passed");
  }
  if (auto failed = exchange::failure(*report, folder)) return tl::unexpected(std::move(*failed));
  return {};
}

Json toJson(const Finding& f) {
  Json out = {{"severity", ecorche::name(f.severity)}, {"kind", f.kind}};
  if (!f.object.empty()) out["object"] = f.object;
  out["message"] = f.message;
  if (f.size != 0.0) out["size"] = f.size;
  if (f.point) out["point_m"] = {f.point->x(), f.point->y(), f.point->z()};
  out["remedy"] = f.remedy;
  return out;
}

void printJson(const engine::ImportCheck& check) {
  Json out = {{"meshes", Json::array()}, {"between", Json::array()}};
  for (const engine::MeshLook& look : check.meshes) {
    Json entry = {{"mesh", look.name},         {"role", engine::name(look.role)},
                  {"vertices", look.vertices}, {"faces", look.faces},
                  {"pieces", look.pieces},     {"closed", look.closed},
                  {"size_m", look.size},       {"findings", Json::array()}};
    if (look.closed) entry["volume_cm3"] = look.volume * 1e6;
    for (const Finding& f : look.findings) entry["findings"].push_back(toJson(f));
    out["meshes"].push_back(std::move(entry));
  }
  for (const Finding& f : check.between) out["between"].push_back(toJson(f));
  for (const Severity s : {Severity::Error, Severity::Warning, Severity::Note}) {
    out["counts"][ecorche::name(s)] = check.count(s);
  }
  fmt::print("{}\n", out.dump(2));
}

/// A sentence for each finding, and below it what is done: tables of sentences fit no terminal.
void printLines(const engine::ImportCheck& check) {
  Table table({{"mesh"},
               {"role"},
               {"faces", Table::Align::Right},
               {"pieces", Table::Align::Right},
               {"closed"},
               {"size [m]", Table::Align::Right},
               {"volume [cm³]", Table::Align::Right},
               {"errors", Table::Align::Right},
               {"warnings", Table::Align::Right},
               {"notes", Table::Align::Right}});
  std::int64_t clean = 0;
  for (const engine::MeshLook& look : check.meshes) {
    clean += look.findings.empty();
    const auto count = [&](Severity s) {
      const auto n = std::ranges::count(look.findings, s, &Finding::severity);
      return n > 0 ? std::to_string(n) : std::string("-");
    };
    table.add({look.name, engine::name(look.role), std::to_string(look.faces),
               std::to_string(look.pieces), look.closed ? "yes" : "no",
               fmt::format("{:.4g}", look.size),
               look.closed ? fmt::format("{:.4g}", look.volume * 1e6) : "-", count(Severity::Error),
               count(Severity::Warning), count(Severity::Note)});
  }
  fmt::print("{}\n", table.text());
  const auto print = [](const std::string& who, const Finding& f) {
    const std::string where = f.point ? fmt::format(" at {:.4g} {:.4g} {:.4g} m", f.point->x(),
                                                    f.point->y(), f.point->z())
                                      : "";
    fmt::print("{}: {}{}{}: {}\n    {}\n", ecorche::name(f.severity), who.empty() ? "" : who + ": ",
               f.kind, where, f.message, f.remedy);
  };
  for (const engine::MeshLook& look : check.meshes) {
    for (const Finding& f : look.findings) print(look.name, f);
  }
  for (const Finding& f : check.between) print("", f);
  fmt::print(
      "{}{} errors, {} warnings, {} notes; {} of {} meshes without findings\n",
      check.count(Severity::Error) + check.count(Severity::Warning) + check.count(Severity::Note) >
              0
          ? "\n"
          : "",
      check.count(Severity::Error), check.count(Severity::Warning), check.count(Severity::Note),
      clean, check.meshes.size());
}

Result<engine::ImportCheck> lookAt(const std::string& file, Session& session) {
  if (std::filesystem::path(file).extension() == ".ecorche") {
    auto project = model::loadProject(file);
    if (!project) return passOn(project);
    auto meshes = engine::loadMeshes(*project, session.run);
    if (!meshes) return passOn(meshes);
    auto check = engine::checkImport(*meshes, engine::cutPlanes(*project),
                                     project->settings.surfaceTolerance, session.run);
    // What was asked for has been done already
    if (check)
      check->between.insert(check->between.begin(), meshes->findings.begin(),
                            meshes->findings.end());
    return check;
  }
  auto mesh = mesh::readMesh(file, {}, session.run);
  if (!mesh) return passOn(mesh);
  mesh->name = std::filesystem::path(file).filename().string();
  auto look = engine::lookAtMesh(*mesh, engine::MeshRole::Unknown, session.run);
  if (!look) return passOn(look);
  return engine::ImportCheck{.meshes = {std::move(*look)}, .between = {}};
}

Result<void> checkMeshes(const std::string& file, Session& session) {
  const auto check = lookAt(file, session);
  if (!check) return passOn(check);
  if (session.globals.json) {
    printJson(*check);
  } else {
    printLines(*check);
  }
  return {};
}

}  // namespace

void addCheck(CLI::App& app, Commands& commands) {
  auto target = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand(
      "check", "Look a mesh or a project's meshes over, or prove a built folder");
  sub->add_option("TARGET", *target, "A folder that build wrote, a project, or a mesh")->required();
  sub->footer(
      "Examples:\n"
      "  ecorche check out                  # every promise, from the written files alone; exit 1 "
      "if one fails\n"
      "  ecorche check forearm.ecorche      # every finding in skin and bones and between them, "
      "with "
      "place, size and what is done about it\n"
      "  ecorche check skin.stl --json");
  commands.push_back({sub, [target](Session& session) {
                        return std::filesystem::is_directory(*target)
                                   ? checkFolder(*target, session)
                                   : checkMeshes(*target, session);
                      }});
}

}  // namespace ecorche::cli
