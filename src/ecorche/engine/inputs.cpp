#include <ecorche/core/parallel.h>
#include <ecorche/engine/inputs.h>
#include <ecorche/mesh/read_mesh.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <utility>

namespace ecorche::engine {

namespace {

// One file in one unit: read once, cut into parts as often as needed
struct FileKey {
  std::filesystem::path path;
  double metresPerUnit = 1.0;
  auto operator<=>(const FileKey&) const = default;
};

Result<mesh::SurfaceMesh> pick(const mesh::SurfaceMesh& whole, const model::MeshRef& ref,
                               const std::string& name) {
  mesh::SurfaceMesh out;
  if (ref.part.empty()) {
    out = whole;
    out.parts.clear();
  } else {
    const auto part =
        std::ranges::find_if(whole.parts, [&](const mesh::Part& p) { return p.name == ref.part; });
    if (part == whole.parts.end()) {
      std::vector<std::string> known;
      for (const auto& p : whole.parts) known.push_back(p.name);
      return fail(
          ErrorCode::UnknownName,
          fmt::format("\"{}\" wants part \"{}\", which the file does not hold; it holds {}", name,
                      ref.part,
                      known.empty() ? "no named part" : fmt::format("{}", fmt::join(known, ", "))),
          {.file = ref.file, .object = name});
    }
    out = mesh::partOf(whole, static_cast<std::size_t>(part - whole.parts.begin()));
  }
  out.name = name;
  return out;
}

}  // namespace

Result<ProjectMeshes> loadMeshes(const model::Project& project, RunContext& run) {
  const Stage stage(run, "read meshes");

  struct Wanted {
    const model::MeshRef* ref;
    std::string name;
    std::string what;                      // in messages
    std::vector<mesh::SurfaceMesh>* list;  // null: the skin
  };
  ProjectMeshes out;
  std::vector<Wanted> wanted{{&project.skin, "skin", "skin", nullptr}};
  for (const auto& bone : project.bones)
    wanted.push_back({&bone.mesh, bone.name, fmt::format("bone \"{}\"", bone.name), &out.bones});
  for (const auto& tissue : project.tissues) {
    if (!tissue.mesh) continue;
    auto& list = tissue.kind == model::Tissue::Kind::Obstacle ? out.obstacles : out.cavities;
    wanted.push_back({&*tissue.mesh, tissue.name,
                      fmt::format("{} \"{}\"", model::word(tissue.kind), tissue.name), &list});
  }

  std::map<FileKey, std::size_t> slot;
  for (const Wanted& w : wanted) {
    const auto next = slot.size();
    slot.try_emplace({meshPath(project, *w.ref), metresPerUnit(project, *w.ref)}, next);
  }
  std::vector<const FileKey*> keys(slot.size());
  for (const auto& [key, index] : slot) keys[index] = &key;
  std::vector<Result<mesh::SurfaceMesh>> files(slot.size());
  parallelFor(
      static_cast<std::int64_t>(keys.size()),
      [&](std::int64_t i) {
        const FileKey& key = *keys[static_cast<std::size_t>(i)];
        files[static_cast<std::size_t>(i)] =
            mesh::readMesh(key.path, {.metresPerUnit = key.metresPerUnit}, run);
      },
      1);

  std::vector<mesh::SurfaceMesh> picked;
  for (const Wanted& w : wanted) {
    const auto& file = files[slot.at({meshPath(project, *w.ref), metresPerUnit(project, *w.ref)})];
    if (!file) {
      Error error = file.error();
      error.message = fmt::format("{}: {}", w.what, error.message);
      if (error.code == ErrorCode::FileMissing)
        error.message += ", relative ones start at the project's folder";
      error.place.object = w.name;
      return tl::unexpected(std::move(error));
    }
    auto mesh = pick(*file, *w.ref, w.name);
    if (!mesh) return passOn(mesh);
    picked.push_back(std::move(*mesh));
  }

  std::vector<Result<mesh::RepairedSurface>> mended(wanted.size());
  parallelFor(
      std::ssize(wanted),
      [&](std::int64_t i) {
        const auto k = static_cast<std::size_t>(i);
        if (wanted[k].ref->repair == mesh::Mending::None) {
          mended[k] = mesh::RepairedSurface{std::move(picked[k]), {}};
        } else {
          mended[k] = mesh::mendSurface(picked[k], wanted[k].ref->repair, run);
        }
      },
      1);
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    if (!mended[k]) return passOn(mended[k]);
    out.findings.insert(out.findings.end(), mended[k]->findings.begin(), mended[k]->findings.end());
    if (wanted[k].list == nullptr) {
      out.skin = std::move(mended[k]->mesh);
    } else {
      wanted[k].list->push_back(std::move(mended[k]->mesh));
    }
  }
  return out;
}

std::vector<std::size_t> curveTissuePlaces(const model::Project& project) {
  std::vector<std::size_t> places;
  for (std::size_t t = 0; t < project.tissues.size(); ++t) {
    if (project.tissues[t].hasCurves()) places.push_back(t);
  }
  return places;
}

std::vector<tissue::CurveTissue> curveTissues(const model::Project& project) {
  std::vector<tissue::CurveTissue> out;
  for (const std::size_t place : curveTissuePlaces(project)) {
    const model::Tissue& from = project.tissues[place];
    tissue::CurveTissue to;
    to.name = from.name;
    to.filler = from.kind == model::Tissue::Kind::Filler;
    to.coreRadius = from.coreRadius;
    to.anisotropy = {from.anisotropy.lambda2, from.anisotropy.lambda3, from.anisotropy.rotation};
    for (std::size_t c = 0; c < from.curves.size(); ++c) {
      to.curves.push_back(
          {from.curves[c].name, splineOf(from.curves[c]), tissueValuesOf(from.curves[c])});
    }
    out.push_back(std::move(to));
  }
  return out;
}

namespace {

fiber::CurveEnd curveEnd(const model::Project& project, const model::Support& support) {
  using On = fiber::CurveEnd::On;
  const auto index = [](std::optional<std::size_t> place) {
    return place ? static_cast<std::int32_t>(*place) : -1;
  };
  switch (support.on) {
    case model::Support::On::Bone:
      return {On::Bone, index(findBone(project, support.name)), {}};
    case model::Support::On::Plane:
      return {On::CutPlane, index(findCutPlane(project, support.name)), {}};
    case model::Support::On::Tissue: {
      const auto place = findTissue(project, support.name);
      return {On::Tissue, place ? tissueId(project, *place).value : -1, {}};
    }
    case model::Support::On::Free:
      break;
  }
  return {};
}

}  // namespace

std::vector<fiber::MuscleEnds> muscleEnds(const model::Project& project) {
  std::vector<fiber::MuscleEnds> out;
  for (const std::size_t place : curveTissuePlaces(project)) {
    const model::Tissue& tissue = project.tissues[place];
    fiber::MuscleEnds ends;
    if (tissue.kind == model::Tissue::Kind::Muscle) {
      for (const model::Curve& curve : tissue.curves) {
        fiber::CurveEnds pair{curveEnd(project, curve.start), curveEnd(project, curve.end)};
        // Attachments known from elsewhere widen the end that sits on the same thing
        for (const model::Attachment& attachment : tissue.attachments) {
          if (!attachment.at) continue;
          const bool origin = attachment.role != model::Attachment::Role::Insertion &&
                              attachment.support == curve.start;
          const bool insertion =
              attachment.role != model::Attachment::Role::Origin && attachment.support == curve.end;
          if (origin) pair.origin.sites.push_back(*attachment.at);
          if (insertion) pair.insertion.sites.push_back(*attachment.at);
        }
        ends.push_back(std::move(pair));
      }
    }
    out.push_back(std::move(ends));
  }
  return out;
}

std::vector<domain::CutPlane> cutPlanes(const model::Project& project) {
  std::vector<domain::CutPlane> out;
  for (const auto& plane : project.cutPlanes)
    out.push_back({plane.name, plane.point, plane.normal});
  return out;
}

std::vector<std::string> fieldNames(const std::vector<tissue::CurveTissue>& tissues) {
  std::vector<std::string> out{"fat"};
  for (const tissue::CurveTissue& tissue : tissues) out.push_back(tissue.name);
  return out;
}

tissue::TissueOptions tissueOptions(const model::Project& project) {
  return {.fat = project.settings.fat,
          .coreRadius = project.settings.coreRadius,
          .alpha = project.settings.alpha};
}

}  // namespace ecorche::engine
