// Every mesh set of the data folder as a domain: what was repaired, how long it took, how far the
// result is from the meshes. `real_meshes [DATA] [--only NAME]` prints the table of
// docs/real_meshes.md.

#include <ecorche/authoring/offset_skin.h>
#include <ecorche/core/parallel.h>
#include <ecorche/domain/build_domain.h>
#include <ecorche/domain/vertex_links.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/surface_topology.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <string>

namespace fs = std::filesystem;
using namespace ecorche;

namespace {

struct Set {
  std::string name;
  std::function<Result<domain::DomainInput>(RunContext&)> read;
  std::int64_t tets = 200000;
};

Result<mesh::SurfaceMesh> meshAt(const fs::path& file, double metresPerUnit, std::string name,
                                 RunContext& run) {
  auto out = mesh::readMesh(file, {metresPerUnit}, run);
  if (!out) return out;
  out->name = std::move(name);
  return out;
}

std::vector<fs::path> filesIn(const fs::path& folder) {
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (mesh::isMeshFile(entry.path())) out.push_back(entry.path());
  }
  std::ranges::sort(out);
  return out;
}

Result<domain::DomainInput> dog(const fs::path& data, RunContext& run) {
  domain::DomainInput in;
  auto skin = meshAt(data / "dog/SKINbody.stl", 1.0, "skin", run);
  if (!skin) return passOn(skin);
  in.skin = std::move(*skin);
  for (const fs::path& file : filesIn(data / "dog/bones")) {
    auto bone = meshAt(file, 1.0, file.stem().string(), run);
    if (!bone) return passOn(bone);
    in.bones.push_back(std::move(*bone));
  }
  return in;
}

// Knees as they are, femur in patches; of the pelvis the compact bone, which overlaps by design.
Result<domain::DomainInput> visibleHuman(const fs::path& data, RunContext& run) {
  domain::DomainInput in;
  const fs::path folder = data / "hra_male";
  auto skin = meshAt(folder / "VH_M_Skin.glb", 1.0, "skin", run);
  if (!skin) return passOn(skin);
  in.skin = std::move(*skin);
  for (const char* side : {"L", "R"}) {
    auto knee = meshAt(folder / fmt::format("VH_M_Knee_{}.glb", side), 1.0,
                       fmt::format("knee {}", side), run);
    if (!knee) return passOn(knee);
    in.bones.push_back(std::move(*knee));
  }
  auto pelvis = meshAt(folder / "VH_M_Pelvis.glb", 1.0, "pelvis", run);
  if (!pelvis) return passOn(pelvis);
  for (std::size_t p = 0; p < pelvis->parts.size(); ++p) {
    if (pelvis->parts[p].name.find("compact_bone") != std::string::npos)
      in.bones.push_back(mesh::partOf(*pelvis, p));
  }
  return in;
}

Result<domain::DomainInput> boneAlone(const fs::path& file, RunContext& run) {
  domain::DomainInput in;
  auto bone = meshAt(file, 1.0, file.stem().string(), run);
  if (!bone) return passOn(bone);
  const double diagonal = mesh::boundingBox(*bone).diagonal();
  auto skin = authoring::offsetSkin({*bone}, authoring::kSkinOffsetRel * diagonal, run);
  if (!skin) return passOn(skin);
  in.skin = std::move(*skin);
  in.bones = {std::move(*bone)};
  return in;
}

Result<domain::DomainInput> makeHuman(const fs::path& data, RunContext& run) {
  domain::DomainInput in;
  auto all = meshAt(data / "makehuman/base.obj", 0.1, "skin", run);
  if (!all) return passOn(all);
  for (std::size_t p = 0; p < all->parts.size(); ++p) {
    if (all->parts[p].name == "body") in.skin = mesh::partOf(*all, p);
  }
  in.skin.name = "skin";
  return in;
}

bool sound(const domain::Domain& d) {
  const auto adjacency = mesh::tetAdjacency(d.mesh.T);
  return mesh::signedVolumes(d.mesh).minCoeff() > 0.0 && adjacency.nonManifoldFaces == 0 &&
         !domain::firstSingularVertex(d.mesh, d.neighbours) && mesh::isClosed(d.boundaryF) &&
         mesh::isManifold(d.boundaryF) && mesh::isOriented(d.boundaryF) &&
         std::abs(mesh::signedVolume(d.mesh.V, d.boundaryF) - d.volume) < 1e-9 * d.volume;
}

std::string findingsText(const Findings& findings) {
  std::map<std::string, int> count;
  for (const Finding& f : findings) ++count[f.kind];
  std::string out;
  for (const auto& [kind, n] : count)
    out +=
        fmt::format("{}{}{}", out.empty() ? "" : ", ", n > 1 ? fmt::format("{} × ", n) : "", kind);
  return out.empty() ? "none" : out;
}

bool measure(const Set& set) {
  RunContext run;
  const auto begin = std::chrono::steady_clock::now();
  const auto in = set.read(run);
  if (!in) {
    fmt::print("| {} | {} |\n", set.name, in.error().text());
    return false;
  }
  std::int64_t faces = in->skin.F.rows();
  for (const auto& bone : in->bones) faces += bone.F.rows();
  domain::DomainOptions options;
  options.tets = set.tets;
  options.useCache = false;
  const auto built = domain::buildDomain(*in, options, run);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (!built) {
    fmt::print("| {} | {} | {} | {} |\n", set.name, in->bones.size(), faces, built.error().text());
    return false;
  }
  const domain::DomainReport& r = built->report;
  const bool green = sound(built->domain) && r.maxDeviation <= r.tolerance;
  fmt::print("| {} | {} | {} | {} | {} | {} | {:.3g}, {:.3g} | {:.0f} | {} | {} |\n", set.name,
             in->bones.size(), faces, findingsText(r.findings), r.tets, r.freeVertices,
             r.maxDeviation * 1e3, r.tolerance * 1e3, seconds, r.mesher, green ? "all" : "NOT all");
  std::fflush(stdout);
  if (std::getenv("ECORCHE_FINDINGS") != nullptr) {
    for (const Finding& f : r.findings)
      fmt::print(stderr, "  {}: {}: {}\n", name(f.severity), f.kind, f.message);
  }
  return green;
}

}  // namespace

int main(int argc, char** argv) {
  fs::path data =
      std::getenv("ECORCHE_DATA") != nullptr ? std::getenv("ECORCHE_DATA") : "../shared/data";
  std::string only;
  for (int i = 1; i < argc; ++i) {
    if (std::string(argv[i]) == "--only" && i + 1 < argc) {
      only = argv[++i];
    } else {
      data = argv[i];
    }
  }
  if (!fs::is_directory(data)) {
    fmt::print(stderr, "there is no folder {}; name the data folder\n", data.string());
    return 2;
  }
  std::vector<Set> sets{
      {"dog, whole", [&](RunContext& run) { return dog(data, run); }, 400000},
      {"Visible Human male", [&](RunContext& run) { return visibleHuman(data, run); }, 200000},
      {"MakeHuman, no bones", [&](RunContext& run) { return makeHuman(data, run); }, 200000}};
  for (const fs::path& file : filesIn(data / "bmf_bones")) {
    sets.push_back({file.stem().string() + " in an offset skin",
                    [file](RunContext& run) { return boneAlone(file, run); }, 60000});
  }
  fmt::print(
      "| set | bones | faces | findings | tets | free vertices | deviation, limit [mm] | time [s] "
      "| "
      "mesher | checks |\n|---|---|---|---|---|---|---|---|---|---|\n");
  int failed = 0;
  for (const Set& set : sets) {
    if (only.empty() || set.name.find(only) != std::string::npos) failed += measure(set) ? 0 : 1;
  }
  return failed == 0 ? 0 : 1;
}
