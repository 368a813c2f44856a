#include <ecorche/authoring/attachments.h>
#include <ecorche/authoring/muscle_heads.h>
#include <ecorche/authoring/names.h>
#include <ecorche/authoring/seats.h>
#include <ecorche/authoring/solid_bone.h>
#include <ecorche/core/parallel.h>
#include <ecorche/engine/centreline.h>
#include <ecorche/engine/stroke_atlas.h>
#include <ecorche/mesh/read_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>

namespace ecorche::engine {

namespace fs = std::filesystem;
using mesh::Vector3;

namespace {

Result<std::vector<fs::path>> meshesIn(const fs::path& folder) {
  std::vector<fs::path> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    if (mesh::isMeshFile(entry.path())) out.push_back(entry.path());
  }
  if (out.empty())
    return fail(ErrorCode::FileMissing, "there is no mesh in this folder",
                {.file = folder.string()});
  std::ranges::sort(out);
  return out;
}

double lengthOf(const std::vector<Vector3>& line) {
  double out = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i) out += (line[i] - line[i - 1]).norm();
  return out;
}

}  // namespace

Result<StrokeAtlas> readStrokeAtlas(const fs::path& folder, RunContext& run) {
  StrokeAtlas out;
  const auto skin = mesh::readMesh(folder / "SKINbody.stl", {}, run);
  if (!skin) return passOn(skin);
  out.skin = std::make_shared<mesh::SurfaceQuery>(*skin);
  const mesh::Box box = mesh::boundingBox(*skin);
  out.diagonal = box.diagonal();
  const auto boneFiles = meshesIn(folder / "bones");
  if (!boneFiles) return passOn(boneFiles);
  out.bones.resize(boneFiles->size());
  std::vector<std::optional<Error>> boneErrors(boneFiles->size());
  parallelFor(
      std::ssize(*boneFiles),
      [&](std::int64_t k) {
        const auto b = static_cast<std::size_t>(k);
        const auto mesh = mesh::readMesh((*boneFiles)[b], {}, run);
        Findings none;
        auto bone = mesh ? authoring::solidBone(authoring::boneNameFrom((*boneFiles)[b]), *mesh,
                                                authoring::kSolidRel * out.diagonal, none, run)
                         : Result<authoring::BoneSurface>(tl::unexpected(mesh.error()));
        if (bone) {
          out.bones[b] = std::move(*bone);
        } else {
          boneErrors[b] = bone.error();
        }
      },
      1);
  for (const auto& error : boneErrors) {
    if (error) return tl::unexpected(*error);
  }
  const auto muscleFiles = meshesIn(folder / "muscles");
  if (!muscleFiles) return passOn(muscleFiles);
  std::map<std::string, fs::path> fileOf;
  for (const fs::path& file : *muscleFiles)
    fileOf[authoring::muscleNameFrom(file.filename().string())] = file;

  auto table = authoring::readAttachments(folder / "attachment_sites.csv", 1.0);
  if (!table) return passOn(table);
  Findings ignored;
  *table = authoring::partedMuscles(*table, out.diagonal, ignored);
  const authoring::FreeSpace space(*out.skin, out.bones);
  std::vector<std::vector<KnownMuscle>> made(table->size());
  std::vector<std::string> why(table->size());
  std::vector<std::optional<Error>> errors(table->size());
  parallelFor(
      std::ssize(*table),
      [&](std::int64_t k) {
        const auto row = static_cast<std::size_t>(k);
        const authoring::MuscleSites& sites = (*table)[row];
        if (run.cancelled() || authoring::sideFrom(sites.muscle) == model::Side::Right) return;
        const auto file = fileOf.find(sites.muscle);
        if (file == fileOf.end()) {
          why[row] = "there is no such mesh";
          return;
        }
        std::vector<authoring::Seat> seats;
        for (const authoring::AttachmentSite& site : sites.sites)
          seats.push_back(authoring::seatOf(site, out.bones, space, out.diagonal));
        const auto heads = authoring::planHeads(sites.sites, seats, box.centre());
        if (heads.empty()) {
          why[row] = "no two attachments";
          return;
        }
        const auto mesh = mesh::readMesh(file->second, {}, run);
        if (!mesh) {
          errors[row] = mesh.error();
          return;
        }
        for (const authoring::HeadPlan& head : heads) {
          const authoring::Seat& from = seats[head.from];
          const authoring::Seat& to = seats[head.to];
          // A fascia's patch has no bone of its own: the nearest one is none of its muscle's
          constexpr double kOnBoneRel = 0.005;
          const auto isOff = [&](const authoring::Seat& seat, std::size_t site) {
            return seat.bone < 0 ||
                   (seat.at - sites.sites[site].at).norm() > kOnBoneRel * out.diagonal;
          };
          if (isOff(from, head.from) || isOff(to, head.to)) {
            why[row] = "an end is on no bone";
            continue;
          }
          if (!from.exposed || !to.exposed) {
            why[row] = "an end lies within bone or skin";
            continue;
          }
          const auto patchA =
              mesh::readMesh(folder / "sites" / sites.sites[head.from].patchFile, {}, run);
          const auto patchB =
              mesh::readMesh(folder / "sites" / sites.sites[head.to].patchFile, {}, run);
          if (!patchA || !patchB) {
            errors[row] = patchA ? patchB.error() : patchA.error();
            return;
          }
          const auto line = centrelineOf(*mesh, *patchA, *patchB);
          if (!line) {
            why[row] = "its surface does not join its attachments";
            continue;
          }
          constexpr double kMostlyInside = 0.8;
          if (line->inside < kMostlyInside) {
            why[row] =
                fmt::format("a sheet so curved that only {:.0f} % of its centreline lie in it",
                            100.0 * line->inside);
            continue;
          }
          made[row].push_back({sites.muscle, from.support.name, to.support.name, from.bone, to.bone,
                               from.at, to.at, line->points, lengthOf(line->points),
                               heads.size() == 1 && head.along.empty()});
        }
      },
      1);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "reading muscles");
  for (std::size_t row = 0; row < made.size(); ++row) {
    if (errors[row]) return tl::unexpected(*errors[row]);
    if (!why[row].empty()) out.leftOut.push_back((*table)[row].muscle + ": " + why[row]);
    out.muscles.insert(out.muscles.end(), made[row].begin(), made[row].end());
  }
  return out;
}

}  // namespace ecorche::engine
