#include <ecorche/authoring/attachments.h>
#include <ecorche/authoring/first_curves.h>
#include <ecorche/authoring/muscle_choice.h>
#include <ecorche/authoring/muscle_heads.h>
#include <ecorche/authoring/names.h>
#include <ecorche/authoring/new_project.h>
#include <ecorche/authoring/offset_skin.h>
#include <ecorche/authoring/solid_bone.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/unit_check.h>
#include <ecorche/model/project_check.h>

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace ecorche::authoring {

namespace fs = std::filesystem;
using mesh::Vector3;

namespace {

/// Where the skin goes that is laid around the bones.
fs::path madeSkinFile(const fs::path& project) {
  return project.parent_path() / (project.stem().string() + "-skin.obj");
}

/// A skin that was laid around the bones, of this project to be or of one beside the file.
bool isMadeSkin(const fs::path& file, const fs::path& target) {
  std::error_code error;
  if (fs::equivalent(file, madeSkinFile(target), error)) return true;
  const std::string name = file.filename().string();
  const std::string end = "-skin.obj";
  if (!name.ends_with(end)) return false;
  const std::string project = name.substr(0, name.size() - end.size()) + ".ecorche";
  return fs::exists(file.parent_path() / project, error);
}

/// @param findings  gets a note for what is in a folder and no bone
Result<std::vector<fs::path>> boneFiles(const NewProjectRequest& request, Findings& findings) {
  std::vector<fs::path> out;
  for (const fs::path& each : request.bones) {
    std::error_code error;
    if (!fs::is_directory(each, error)) {
      out.push_back(each);
      continue;
    }
    std::vector<fs::path> inFolder;
    for (const auto& entry : fs::directory_iterator(each, error)) {
      if (!entry.is_regular_file(error) || !mesh::isMeshFile(entry.path())) continue;
      if (!request.skin.empty() && fs::equivalent(entry.path(), request.skin, error)) continue;
      if (!isMadeSkin(entry.path(), request.target)) {
        inFolder.push_back(entry.path());
        continue;
      }
      const std::string name = entry.path().filename().string();
      findings.push_back(
          {.severity = Severity::Note,
           .kind = "made-skin",
           .object = name,
           .message = fmt::format("{} was laid around bones by this program, so it is taken for "
                                  "none; name the file itself if it is one",
                                  name)});
    }
    if (error && inFolder.empty()) {
      return fail(ErrorCode::FileNotReadable, "this folder cannot be read",
                  {.file = each.string()});
    }
    if (inFolder.empty()) {
      return fail(ErrorCode::FileMissing,
                  "there is no mesh in this folder (obj, ply, stl, off, glb, fbx …)",
                  {.file = each.string()});
    }
    std::ranges::sort(inFolder);
    out.insert(out.end(), inFolder.begin(), inFolder.end());
  }
  return out;
}

struct NamedMesh {
  model::Bone bone;
  mesh::SurfaceMesh mesh;
};

Result<std::vector<NamedMesh>> readBones(const NewProjectRequest& request, const fs::path& folder,
                                         Findings& findings, RunContext& run) {
  const auto files = boneFiles(request, findings);
  if (!files) return passOn(files);
  const mesh::ReadOptions options{model::metresPer(request.unit)};
  std::vector<NamedMesh> out;
  std::vector<std::string> names;
  const Stage stage(run, "reading bones");
  for (std::size_t k = 0; k < files->size(); ++k) {
    run.progress("reading bones", static_cast<double>(k) / static_cast<double>(files->size()));
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "reading bones");
    const fs::path& file = (*files)[k];
    auto read = mesh::readMesh(file, options, run);
    if (!read) return passOn(read);
    const std::string path = model::pathFrom(folder, file);
    if (read->parts.size() < 2) {
      names.push_back(boneNameFrom(file));
      out.push_back({{"", {path, "", {}}}, std::move(*read)});
      continue;
    }
    for (std::size_t part = 0; part < read->parts.size(); ++part) {
      const std::string& partName = read->parts[part].name;
      if (partName.empty() || read->parts[part].faceCount == 0) continue;
      names.push_back(boneNameFrom(partName + ".part"));
      out.push_back({{"", {path, partName, {}}}, mesh::partOf(*read, part)});
    }
  }
  names = madeUnique(std::move(names));
  for (std::size_t k = 0; k < out.size(); ++k) out[k].bone.name = names[k];
  return out;
}

Result<mesh::SurfaceMesh> readSkin(const NewProjectRequest& request, RunContext& run) {
  const Stage stage(run, "reading skin");
  auto skin = mesh::readMesh(request.skin, {model::metresPer(request.unit)}, run);
  if (!skin) return skin;
  skin->name = "skin";
  if (request.skinPart.empty()) return skin;
  for (std::size_t part = 0; part < skin->parts.size(); ++part) {
    if (skin->parts[part].name == request.skinPart) return mesh::partOf(*skin, part);
  }
  std::string known;
  for (const mesh::Part& part : skin->parts) known += (known.empty() ? "" : ", ") + part.name;
  return fail(ErrorCode::UnknownName,
              fmt::format("there is no part \"{}\"; the file has {}", request.skinPart,
                          known.empty() ? "none" : known),
              {.file = request.skin.string()});
}

// A skin as it was given and mended as it was asked to be, or one laid around the bones.
Result<mesh::SurfaceMesh> findSkin(const NewProjectRequest& request,
                                   const std::vector<NamedMesh>& bones, NewProject& out,
                                   RunContext& run) {
  if (!request.skin.empty()) {
    out.project.skin = {model::pathFrom(out.project.folder, request.skin), request.skinPart, {}};
    out.project.skin.repair = request.repairSkin;
    const auto given = readSkin(request, run);
    if (!given) return given;
    auto mended = mesh::mendSurface(*given, request.repairSkin, run);
    if (!mended) return passOn(mended);
    out.findings.insert(out.findings.end(), mended->findings.begin(), mended->findings.end());
    return std::move(mended->mesh);
  }
  if (bones.empty()) {
    return fail(ErrorCode::MissingKey,
                "there is neither a skin nor a bone; give --skin, --bones or both",
                {.file = request.target.string()});
  }
  std::vector<mesh::SurfaceMesh> meshes;
  mesh::Box box;
  for (const NamedMesh& bone : bones) {
    meshes.push_back(bone.mesh);
    meshes.back().name = bone.bone.name;
    box.add(mesh::boundingBox(bone.mesh));
  }
  const double distance = request.skinOffset.value_or(kSkinOffsetRel * box.diagonal());
  auto skin = offsetSkin(meshes, distance, run);
  if (!skin) return skin;
  out.skinFile = madeSkinFile(request.target);
  out.project.skin = {model::pathFrom(out.project.folder, out.skinFile), "", {}};
  if (request.unit != model::Unit::Metre) out.project.skin.unit = model::Unit::Metre;
  out.madeSkin = *skin;
  out.findings.push_back(
      {.severity = Severity::Note,
       .kind = "offset-skin",
       .object = "skin",
       .message = fmt::format("there was no skin: one was laid {:.3g} mm outside the bones, {} "
                              "faces, in {}; sculpt it, or choose another distance with --offset",
                              distance * 1e3, skin->F.rows(), out.skinFile.string()),
       .size = distance});
  return skin;
}

// Bones in another unit, or nowhere near the skin, are told before anything is made of them.
void compareScales(const mesh::SurfaceMesh& skinMesh, const std::vector<NamedMesh>& bones,
                   Findings& findings) {
  const mesh::Box skin = mesh::boundingBox(skinMesh);
  std::vector<mesh::SurfaceMesh> meshes;
  for (const NamedMesh& bone : bones) {
    meshes.push_back(bone.mesh);
    meshes.back().name = bone.bone.name;
  }
  for (const mesh::UnitMismatch& mismatch : mesh::unitMismatches(skinMesh, meshes)) {
    const auto& bone = meshes[mismatch.bone.value_or(0)];
    findings.push_back({.severity = Severity::Warning,
                        .kind = "units",
                        .object = bone.name,
                        .message = mismatch.message,
                        .point = mesh::boundingBox(bone).centre(),
                        .size = mismatch.factor});
  }
  if (!findings.empty() && findings.back().kind == "units") return;
  mesh::Box all;
  for (const NamedMesh& bone : bones) all.add(mesh::boundingBox(bone.mesh));
  if (bones.empty() || all.empty() || skin.empty()) return;
  const double ratio = all.diagonal() / skin.diagonal();
  const bool apart =
      ((all.lo - skin.hi).array() > 0.0).any() || ((skin.lo - all.hi).array() > 0.0).any();
  if (ratio > 0.05 && ratio < 5.0 && !apart) return;
  findings.push_back(
      {Severity::Warning, "scale", "skin",
       fmt::format("the bones measure {:.3g} m corner to corner and the skin {:.3g} m{}; are they "
                   "in the same unit and frame?",
                   all.diagonal(), skin.diagonal(), apart ? ", and they do not meet" : ""),
       all.centre()});
}

std::optional<model::CutPlane> cutPlaneFrom(const ParsedSymmetry& asked,
                                            const std::optional<SymmetryPlane>& found) {
  model::CutPlane plane{"median", model::CutPlane::Kind::Symmetry, Vector3::Zero(),
                        Vector3::UnitY()};
  if (const auto* given = std::get_if<GivenSymmetry>(&asked.choice)) {
    plane.normal = Vector3::Unit(given->axis);
    plane.point = given->offset * plane.normal;
  } else if (found) {
    plane.point = found->point;
    plane.normal = found->normal;
  } else {
    return std::nullopt;
  }
  if (asked.flip) plane.normal = -plane.normal;
  plane.normal += Vector3::Zero();  // no −0 in files
  return plane;
}

// Bones with an inside, so that curves can be kept out of them.
Result<std::vector<BoneSurface>> solidBones(const std::vector<NamedMesh>& bones, double diagonal,
                                            Findings& findings, RunContext& run) {
  const Stage stage(run, "making bones solid");
  std::vector<Result<BoneSurface>> made(bones.size());
  std::vector<Findings> notes(bones.size());
  parallelFor(
      std::ssize(bones),
      [&](std::int64_t k) {
        const auto i = static_cast<std::size_t>(k);
        made[i] = solidBone(bones[i].bone.name, bones[i].mesh, kSolidRel * diagonal, notes[i], run);
      },
      1);
  std::vector<BoneSurface> out;
  for (std::size_t i = 0; i < bones.size(); ++i) {
    if (!made[i]) return passOn(made[i]);
    out.push_back(std::move(*made[i]));
    findings.insert(findings.end(), notes[i].begin(), notes[i].end());
  }
  return out;
}

// Patches lie beside the table or in its folder "sites"; those that are not there are not named.
void findPatches(std::vector<model::Tissue>& muscles, const fs::path& folder,
                 const fs::path& projectFolder) {
  for (model::Tissue& muscle : muscles) {
    for (model::Attachment& attachment : muscle.attachments) {
      if (!attachment.patch) continue;
      std::optional<std::string> file;
      for (const fs::path& place :
           {folder / attachment.patch->file, folder / "sites" / attachment.patch->file}) {
        std::error_code ignored;
        if (fs::is_regular_file(place, ignored)) file = model::pathFrom(projectFolder, place);
      }
      if (file) {
        attachment.patch->file = *file;
      } else {
        attachment.patch.reset();
      }
    }
  }
}

// First curves for the chosen muscles of a table, in its order.
Result<std::vector<model::Tissue>> musclesFrom(const NewProjectRequest& request,
                                               const mesh::SurfaceMesh& skin,
                                               const std::vector<NamedMesh>& bones, NewProject& out,
                                               RunContext& run) {
  auto table = readAttachments(*request.attachments, model::metresPer(request.unit));
  if (!table) return passOn(table);
  out.musclesInTable = table->size();
  const mesh::Box box = mesh::boundingBox(skin);
  const double diagonal = box.diagonal();

  std::optional<Mirror> mirror;
  Findings taken;
  if (out.mirror) {
    mirror = Mirror{out.mirror->point, out.mirror->normal};
    *table = withTwinSites(*table, *mirror, diagonal, taken);
  }
  if (!request.muscles.empty()) {
    table = chosenMuscles(*table, request.muscles);
    if (!table) {
      Error error = table.error();
      error.place.file = request.attachments->string();
      return tl::unexpected(std::move(error));
    }
  }
  std::ranges::copy_if(taken, std::back_inserter(out.findings), [&](const Finding& finding) {
    return std::ranges::find(*table, finding.object, &MuscleSites::muscle) != table->end();
  });
  *table = partedMuscles(*table, diagonal, out.findings);
  const auto surfaces = solidBones(bones, diagonal, out.findings, run);
  if (!surfaces) return passOn(surfaces);

  const Stage stage(run, "first curves");
  const mesh::SurfaceQuery skinQuery(skin);
  Surroundings around{skinQuery, *surfaces, diagonal, box.centre(), mirror, request.whole};
  if (out.mirror) around.plane = out.mirror->name;
  auto made = firstMuscles(*table, around, run);
  if (!made) return passOn(made);
  out.findings.insert(out.findings.end(), made->findings.begin(), made->findings.end());
  findPatches(made->muscles, request.attachments->parent_path(), out.project.folder);
  return std::move(made->muscles);
}

}  // namespace

std::optional<ParsedSymmetry> symmetryFrom(std::string_view text, model::Unit unit) {
  if (text == "auto") return ParsedSymmetry{FindSymmetry{}};
  if (text == "none") return ParsedSymmetry{NoSymmetry{}};
  ParsedSymmetry out;
  if (text.starts_with('-')) {
    out.flip = true;
    text.remove_prefix(1);
  }
  GivenSymmetry given;
  if (text.empty()) return std::nullopt;
  const std::size_t axis = std::string_view("xyzXYZ").find(text.front());
  if (axis == std::string_view::npos) return std::nullopt;
  given.axis = static_cast<int>(axis % 3);
  text.remove_prefix(1);
  if (!text.empty()) {
    if (text.front() != '=') return std::nullopt;
    const auto offset = model::lengthFrom(text.substr(1), unit);
    if (!offset) return std::nullopt;
    given.offset = *offset;
  }
  out.choice = given;
  return out;
}

Result<NewProject> newProject(const NewProjectRequest& request, RunContext& run) {
  NewProject out;
  out.project.folder = request.target.parent_path();
  out.project.name = request.target.stem().string();
  out.project.unit = request.unit;
  const auto bones = readBones(request, out.project.folder, out.findings, run);
  if (!bones) return passOn(bones);
  const auto skin = findSkin(request, *bones, out, run);
  if (!skin) return passOn(skin);
  for (const NamedMesh& each : *bones) out.project.bones.push_back(each.bone);
  compareScales(*skin, *bones, out.findings);

  if (std::holds_alternative<FindSymmetry>(request.symmetry.choice)) {
    const auto found = findSymmetryPlane(*skin, {}, run);
    if (!found) return passOn(found);
    out.symmetry = *found;
    if (!out.symmetry) {
      out.findings.push_back({Severity::Note,
                              "no-symmetry",
                              "skin",
                              "no plane mirrors the skin onto itself, so the whole of it is kept",
                              {}});
    }
  }
  out.mirror = cutPlaneFrom(request.symmetry, out.symmetry);
  if (out.mirror && !request.whole) out.project.cutPlanes.push_back(*out.mirror);

  if (request.attachments) {
    auto muscles = musclesFrom(request, *skin, *bones, out, run);
    if (!muscles) return passOn(muscles);
    out.project.tissues = std::move(*muscles);
  }
  if (auto fault = model::findFault(out.project)) {
    return fail(fault->code, std::move(fault->message), {.object = std::move(fault->object)});
  }
  return out;
}

}  // namespace ecorche::authoring
