#include <ecorche/engine/bench.h>
#include <ecorche/model/project_check.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/solve_tissues.h>

#include <algorithm>
#include <cmath>

namespace ecorche::engine {

namespace {

constexpr double kLeastVolume = 5e-6;  // m³: smaller muscles do not count alone

void scale(std::vector<mesh::SurfaceMesh>& meshes, double factor) {
  for (mesh::SurfaceMesh& m : meshes) m.V *= factor;
}

model::Project scaled(model::Project project, double factor) {
  const auto times = [&](std::optional<double>& length) {
    if (length) *length *= factor;
  };
  times(project.settings.coreRadius);
  times(project.settings.edgeLength);
  for (auto& plane : project.cutPlanes) plane.point *= factor;
  for (auto& tissue : project.tissues) {
    times(tissue.coreRadius);
    for (auto& curve : tissue.curves) {
      for (auto& p : curve.points) p.at *= factor;
    }
  }
  return project;
}

struct Solved {
  domain::Domain domain;
  std::vector<double> volume;  // by id − 1
};

Result<Solved> solve(const model::Project& project, ProjectMeshes meshes, double factor,
                     std::optional<std::int64_t> tets, RunContext& run) {
  const model::Project own = scaled(project, factor);
  meshes.skin.V *= factor;
  for (auto* list : {&meshes.bones, &meshes.obstacles, &meshes.cavities}) scale(*list, factor);
  auto built = buildDomainOf(own, meshes, {.tets = tets}, run);
  if (!built) return passOn(built);
  const auto solved =
      tissue::solveTissues(built->domain, curveTissues(own), tissueOptions(own), run);
  if (!solved) return passOn(solved);
  Solved out;
  out.volume = tissue::tissueVolumes(built->domain.mesh, solved->fields);
  out.domain = std::move(built->domain);
  return out;
}

Result<ResolutionBench> measured(const model::Project& project,
                                 const std::vector<BuildOptions>& domains, RunContext& run) {
  if (auto sound = model::checkProject(project); !sound) return passOn(sound);
  ResolutionBench out;
  out.tissues = curveTissues(project);
  for (const BuildOptions& options : domains) {
    auto prepared = prepareDomain(project, options, run);
    if (!prepared) return passOn(prepared);
    auto now =
        tissue::measureResolution(prepared->build.domain, out.tissues, tissueOptions(project), run);
    if (!now) return passOn(now);
    out.cases.push_back(std::move(*now));
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped between two domains");
  }
  out.ours = tissue::volumeChange(out.cases, out.tissues, false, kLeastVolume);
  out.paper = tissue::volumeChange(out.cases, out.tissues, true, kLeastVolume);
  return out;
}

}  // namespace

Result<ResolutionBench> benchResolution(const model::Project& project,
                                        const std::vector<std::int64_t>& tets, RunContext& run) {
  std::vector<BuildOptions> domains;
  for (const std::int64_t wanted : tets) domains.push_back({.tets = wanted});
  return measured(project, domains, run);
}

Result<ResolutionBench> benchPreview(const model::Project& project, std::int64_t preview,
                                     Sizing sizing, std::optional<std::int64_t> tets,
                                     RunContext& run) {
  return measured(project, {{.tets = preview, .sizing = sizing}, {.tets = tets}}, run);
}

Result<std::vector<ScaleCase>> benchScale(const model::Project& project,
                                          const std::vector<double>& factors,
                                          std::optional<std::int64_t> tets, RunContext& run) {
  if (auto sound = model::checkProject(project); !sound) return passOn(sound);
  auto meshes = loadMeshes(project, run);
  if (!meshes) return passOn(meshes);
  const auto tissues = curveTissues(project);
  const auto reference = solve(project, *meshes, 1.0, tets, run);
  if (!reference) return passOn(reference);

  std::vector<ScaleCase> out;
  for (const double factor : factors) {
    const auto solved = solve(project, *meshes, factor, tets, run);
    if (!solved) return passOn(solved);
    ScaleCase c;
    c.factor = factor;
    c.tets = solved->domain.mesh.T.rows();
    c.sameTets = solved->domain.mesh.T.rows() == reference->domain.mesh.T.rows() &&
                 solved->domain.mesh.T == reference->domain.mesh.T;
    double total = 0.0;
    double totalBefore = 0.0;
    for (std::size_t i = 0; i < solved->volume.size(); ++i) {
      const double before = reference->volume[i];
      const double now = solved->volume[i] / (factor * factor * factor);
      const double share = solved->volume[i] / solved->domain.volume;
      c.shareChange = std::max(c.shareChange, std::abs(share - before / reference->domain.volume));
      if (i == 0 || tissues[i - 1].filler) continue;
      total += now;
      totalBefore += before;
      const double change = std::abs(now / before - 1.0);
      if (before < kLeastVolume || !(change > c.largestChange)) continue;
      c.largestChange = change;
      c.tissue = i - 1;
    }
    c.totalChange = std::abs(total / totalBefore - 1.0);
    out.push_back(c);
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped between two scales");
  }
  return out;
}

}  // namespace ecorche::engine
