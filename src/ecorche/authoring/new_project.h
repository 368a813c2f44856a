#pragma once

#include <ecorche/authoring/symmetry.h>
#include <ecorche/core/finding.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/model/project.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace ecorche::authoring {

/// How a new project gets its symmetry plane.
struct FindSymmetry {};
struct NoSymmetry {};
struct GivenSymmetry {
  int axis = 1;         ///< of the normal: 0, 1, 2
  double offset = 0.0;  ///< of the plane along it [m]
};
using SymmetryChoice = std::variant<FindSymmetry, NoSymmetry, GivenSymmetry>;

/// "auto", "none", "y", "-y" or "y=0.1" (the plane's offset in `unit`); the kept half is where the
/// axis, or with a minus its opposite, points. Nothing where the text is none of these.
struct ParsedSymmetry {
  SymmetryChoice choice;
  bool flip = false;  ///< keep the other half
};
[[nodiscard]] std::optional<ParsedSymmetry> symmetryFrom(std::string_view text, model::Unit unit);

struct NewProjectRequest {
  std::filesystem::path target;  ///< project file to be; not written here, paths are relative to it
  std::filesystem::path skin;    ///< empty: one is laid around the bones
  std::string skinPart;          ///< empty: the whole file
  std::vector<std::filesystem::path> bones;  ///< files, or folders whose meshes are all taken
  /// How far a skin that is laid around the bones lies from them [m]. Unset: kSkinOffsetRel of the
  /// bones' diagonal.
  std::optional<double> skinOffset;
  mesh::Mending repairSkin = mesh::Mending::None;  ///< written down for `build`, and done here
  std::optional<std::filesystem::path> attachments;
  std::vector<std::string> muscles;  ///< of the table, see chosenMuscles; empty: all
  ParsedSymmetry symmetry{NoSymmetry{}};
  /// Keep both halves of a symmetric body: the plane makes left and right muscles alike, but cuts
  /// nothing off.
  bool whole = false;
  model::Unit unit = model::Unit::Metre;  ///< of all these files
};

struct NewProject {
  model::Project project;
  std::optional<SymmetryPlane> symmetry;  ///< where one was looked for and found
  std::optional<model::CutPlane> mirror;  ///< found or given, whether it cuts or not
  std::size_t musclesInTable = 0;
  /// A skin laid around the bones: to be written in metres to `skinFile`, before the project.
  std::optional<mesh::SurfaceMesh> madeSkin;
  std::filesystem::path skinFile;
  Findings findings;  ///< what was left out, what looks wrong
};

/// Reads the meshes and writes down a first project: one bone per file, or per part of a file that
/// has several; bone names from files and parts; a symmetry plane as a cut plane; with a table of
/// attachments, a first curve per muscle.
/// Without a skin one is laid around the bones and goes beside the project as NAME-skin.obj;
/// without bones the skin is all there is.
/// @errors  those of readMesh, mendSurface, readAttachments and findFault; MissingKey (neither skin
/// nor bones); FileMissing (a folder without
/// meshes), UnknownName (no such
///          part), Cancelled
[[nodiscard]] Result<NewProject> newProject(const NewProjectRequest& request, RunContext& run);

}  // namespace ecorche::authoring
