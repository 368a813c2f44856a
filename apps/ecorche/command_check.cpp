#include <ecorche/engine/inputs.h>
#include <ecorche/exchange/check_anatomy.h>
#include <ecorche/exchange/report.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/model/project_file.h>
#include <fmt/format.h>

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

// What a surface is worth as an input: findings as a table or as JSON
void printFindings(const std::vector<std::pair<std::string, Findings>>& meshes, bool json) {
  if (json) {
    Json out = Json::array();
    for (const auto& [name, findings] : meshes) {
      Json entry = {{"mesh", name}, {"findings", Json::array()}};
      for (const Finding& f : findings) {
        Json item = {
            {"severity", ecorche::name(f.severity)}, {"kind", f.kind}, {"message", f.message}};
        if (f.size != 0.0) item["size"] = f.size;
        if (f.point) item["point_m"] = {f.point->x(), f.point->y(), f.point->z()};
        entry["findings"].push_back(std::move(item));
      }
      out.push_back(std::move(entry));
    }
    fmt::print("{}\n", out.dump(2));
    return;
  }
  Table table({{"mesh"}, {"severity"}, {"kind"}, {"where [m]"}, {"what"}});
  std::size_t clean = 0;
  for (const auto& [name, findings] : meshes) {
    clean += findings.empty();
    for (const Finding& f : findings) {
      table.add({name, ecorche::name(f.severity), f.kind,
                 f.point
                     ? fmt::format("{:.3f} {:.3f} {:.3f}", f.point->x(), f.point->y(), f.point->z())
                     : "-",
                 f.message});
    }
  }
  if (clean < meshes.size()) fmt::print("{}\n", table.text());
  fmt::print("{} of {} meshes without findings\n", clean, meshes.size());
}

constexpr mesh::SurfaceCheckOptions kAll{.selfIntersections = true};

Result<void> checkMeshes(const std::string& file, Session& session) {
  std::vector<std::pair<std::string, Findings>> out;
  if (std::filesystem::path(file).extension() == ".ecorche") {
    auto project = model::loadProject(file);
    if (!project) return passOn(project);
    auto meshes = engine::loadMeshes(*project, session.run);
    if (!meshes) return passOn(meshes);
    out.emplace_back("skin", mesh::checkSurface(meshes->skin, kAll).findings);
    for (const auto* list : {&meshes->bones, &meshes->obstacles, &meshes->cavities}) {
      for (const auto& m : *list) out.emplace_back(m.name, mesh::checkSurface(m, kAll).findings);
    }
  } else {
    auto mesh = mesh::readMesh(file, {}, session.run);
    if (!mesh) return passOn(mesh);
    out.emplace_back(std::filesystem::path(file).filename().string(),
                     mesh::checkSurface(*mesh, kAll).findings);
  }
  printFindings(out, session.globals.json);
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
      "  ecorche check forearm.ecorche      # findings in skin and bones\n"
      "  ecorche check skin.stl --json");
  commands.push_back({sub, [target](Session& session) {
                        return std::filesystem::is_directory(*target)
                                   ? checkFolder(*target, session)
                                   : checkMeshes(*target, session);
                      }});
}

}  // namespace ecorche::cli
