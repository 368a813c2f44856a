#include <ecorche/authoring/muscle_choice.h>
#include <ecorche/authoring/new_project.h>
#include <ecorche/mesh/write_mesh.h>
#include <ecorche/model/project_file.h>

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli.h"

namespace ecorche::cli {

namespace {

using namespace authoring;
using Json = nlohmann::ordered_json;

struct NewOptions {
  std::string skin, skinPart, attachments, muscles, output;
  std::vector<std::string> bones;
  std::string symmetry = "auto";
  std::string unit = "m";
  bool whole = false;
  std::string repairSkin = "none";
  std::optional<double> offset;
  bool force = false;
};

Json toJson(const NewProject& made, const std::string& file) {
  const model::Project& project = made.project;
  Json json = {
      {"project", file}, {"bones", project.bones.size()}, {"muscles", project.tissues.size()}};
  if (made.musclesInTable > 0) json["muscles_in_table"] = made.musclesInTable;
  if (made.mirror) {
    const auto &p = made.mirror->point, &n = made.mirror->normal;
    json["symmetry"] = {{"point_m", {p.x(), p.y(), p.z()}},
                        {"normal", {n.x(), n.y(), n.z()}},
                        {"cuts", !project.cutPlanes.empty()}};
    if (made.symmetry) json["symmetry"]["error_rel"] = made.symmetry->error;
  }
  json["findings"] = Json::array();
  for (const Finding& finding : made.findings) {
    json["findings"].push_back({{"severity", name(finding.severity)},
                                {"kind", finding.kind},
                                {"object", finding.object},
                                {"message", finding.message}});
  }
  return json;
}

void print(const NewProject& made, const std::string& file) {
  const model::Project& project = made.project;
  fmt::print("{}: {} bones", file, project.bones.size());
  if (made.musclesInTable > 0)
    fmt::print(", {} of {} muscles of the table", project.tissues.size(), made.musclesInTable);
  fmt::print("\n");
  if (made.mirror) {
    const auto &p = made.mirror->point, &n = made.mirror->normal;
    const bool cuts = !project.cutPlanes.empty();
    fmt::print("symmetry plane through {:.4g}, {:.4g}, {:.4g} m; ", p.x(), p.y(), p.z());
    if (cuts) {
      fmt::print("the side of {:.4g}, {:.4g}, {:.4g} is kept", n.x(), n.y(), n.z());
    } else {
      fmt::print("both sides are kept and made alike");
    }
    if (made.symmetry)
      fmt::print(" (the mirrored skin misses itself by {:.3f} % of its diagonal{})",
                 100 * made.symmetry->error, cuts ? "; --whole keeps all" : "");
    fmt::print("\n");
  }
  std::size_t otherHalf = 0;
  for (const Finding& finding : made.findings) {
    if (finding.kind == "other-half") {
      ++otherHalf;
    } else {
      fmt::print("{}: {}\n", name(finding.severity), finding.message);
    }
  }
  if (otherHalf > 0)
    fmt::print("{}: {} muscles belong to the removed side\n", name(Severity::Note), otherHalf);
}

Result<void> makeProject(const NewOptions& options, const ParsedSymmetry& symmetry,
                         Session& session) {
  if (!options.force && std::filesystem::exists(options.output)) {
    return fail(ErrorCode::FileNotWritable,
                "this file exists already; choose another name or add --force",
                {.file = options.output});
  }
  NewProjectRequest request;
  request.target = options.output;
  request.skin = options.skin;
  request.skinPart = options.skinPart;
  request.bones.assign(options.bones.begin(), options.bones.end());
  if (!options.attachments.empty()) request.attachments = options.attachments;
  if (!options.muscles.empty()) {
    auto names = muscleNamesFrom(options.muscles);
    if (!names) return passOn(names);
    request.muscles = std::move(*names);
  }
  request.symmetry = symmetry;
  request.whole = options.whole;
  request.unit = *model::unitFrom(options.unit);
  request.repairSkin = *mesh::mendingNamed(options.repairSkin);
  if (options.offset) request.skinOffset = *options.offset * model::metresPer(request.unit);
  const auto made = newProject(request, session.run);
  if (!made) return passOn(made);
  if (session.run.cancelled())
    return fail(ErrorCode::Cancelled, "interrupted; nothing was written");
  if (made->madeSkin) {
    if (!options.force && std::filesystem::exists(made->skinFile)) {
      return fail(ErrorCode::FileNotWritable,
                  "the skin made for the bones goes here, but this file exists already; choose "
                  "another name for the project or add --force",
                  {.file = made->skinFile.string()});
    }
    if (auto saved = mesh::writeObj(*made->madeSkin, made->skinFile); !saved) return saved;
  }
  if (auto saved = model::saveProject(made->project, options.output); !saved) return saved;
  if (session.globals.json) {
    fmt::print("{}\n", toJson(*made, options.output).dump(2));
  } else if (!session.globals.quiet) {
    print(*made, options.output);
  }
  return {};
}

}  // namespace

void addNew(CLI::App& app, Commands& commands) {
  CLI::App* const sub = app.add_subcommand(
      "new", "Make a project from a skin, bones and, if there is one, a table of attachments");
  const auto options = std::make_shared<NewOptions>();
  CLI::Option* const skin = sub->add_option(
      "--skin", options->skin,
      "Closed skin mesh (obj, ply, stl, off, glb, fbx ...); without one, a skin is laid around the "
      "bones");
  sub->add_option("--skin-part", options->skinPart, "One named part of that file");
  sub->add_option("--bones", options->bones,
                  "Bone meshes, or a folder of them; files with several parts give several bones");
  sub->add_option("--offset", options->offset,
                  "How far the skin laid around the bones lies from them, in --unit (default: 3 % "
                  "of the bones' diagonal)")
      ->check(CLI::PositiveNumber)
      ->excludes(skin);
  sub->add_option("--repair-skin", options->repairSkin,
                  "What is done to a skin that is open, hollow or cuts itself: fill-holes, "
                  "outer-hull or wrap")
      ->check(CLI::IsMember({"none", "fill-holes", "outer-hull", "wrap"}))
      ->capture_default_str();
  sub->add_option("--attachments", options->attachments,
                  "CSV with columns muscle, role, bone, x, y, z: gives each muscle a first curve");
  sub->add_option(
         "--muscles", options->muscles,
         "Only these muscles of the table: names with commas between them, or a file with one "
         "a line; a name without a side means both")
      ->needs("--attachments");
  sub->add_option("--symmetry", options->symmetry,
                  "auto: find it; none; or a plane: y, -y, y=0.02. What the axis points at is "
                  "kept, with a minus the other half")
      ->capture_default_str();
  sub->add_flag("--whole", options->whole,
                "Keep both halves: the symmetry plane makes left and right muscles alike and cuts "
                "nothing off");
  sub->add_option("--unit", options->unit, "Unit of all these files")
      ->check(CLI::IsMember({"m", "dm", "cm", "mm", "in"}))
      ->capture_default_str();
  sub->add_option("-o,--output", options->output, "The project file to write (.ecorche)")
      ->required();
  sub->add_flag("--force", options->force, "Replace an existing project file");
  sub->footer(
      "Meshes stay where they are; the project names them relative to itself.\n\nExamples:\n"
      "  ecorche new --skin skin.obj --bones bones/ -o horse.ecorche\n"
      "  ecorche new --bones skeleton/ --unit mm --offset 20 -o fossil.ecorche\n"
      "  ecorche new --skin head-ct.stl --repair-skin fill-holes --bones skull.stl -o "
      "head.ecorche\n"
      "  ecorche new --skin body.glb --bones femur.stl tibia.stl --unit mm --symmetry none -o "
      "leg.ecorche\n"
      "  ecorche new --skin SKINbody.stl --bones bones --attachments sites.csv -o dog.ecorche\n"
      "  ecorche new --skin skin.stl --bones bones --attachments sites.csv --whole --muscles "
      "sartorius,gracilis -o thighs.ecorche");
  // A plane that cannot be read is wrong usage, like any other malformed option
  sub->final_callback([options] {
    if (options->skin.empty() && options->bones.empty())
      throw CLI::ValidationError("--skin", "is missing, and so is --bones; give one or both");
    const auto unit = model::unitFrom(options->unit);
    if (unit && !symmetryFrom(options->symmetry, *unit)) {
      throw CLI::ValidationError("--symmetry",
                                 "must be auto, none or a plane like y, -y or y=0.02");
    }
  });
  commands.push_back(
      {sub, [options](Session& session) {
         return makeProject(
             *options, *symmetryFrom(options->symmetry, *model::unitFrom(options->unit)), session);
       }});
}

}  // namespace ecorche::cli
