#include <ecorche/engine/build.h>
#include <ecorche/engine/sizing.h>
#include <ecorche/model/project_check.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/tissue_solver.h>

#include <algorithm>

namespace ecorche::engine {

namespace {

// Aim: eight tets across every muscle (docs/decisions.md), before the domain scales all lengths to
// its budget
constexpr double kTetsAcross = 8.0;

// Sizing wants one length for a run of curve: short runs, so that a muscle may be thick in the
// belly and thin at its ends
std::vector<domain::SizingCurve> sizingCurves(const std::vector<tissue::CurveTissue>& tissues,
                                              const mesh::SurfaceMesh& skin) {
  constexpr std::size_t kRun = 4;
  const double diagonal = mesh::boundingBox(skin).diagonal();
  std::vector<domain::SizingCurve> out;
  for (const CurveRoom& room : roomAroundCurves(tissues, skin, 0.002 * diagonal)) {
    for (std::size_t begin = 0; begin + 1 < room.point.size(); begin += kRun) {
      const std::size_t end = std::min(room.point.size(), begin + kRun + 1);
      domain::SizingCurve run;
      run.points.resize(static_cast<Eigen::Index>(end - begin), 3);
      double radius = 0.0;
      for (std::size_t i = begin; i < end; ++i) {
        run.points.row(static_cast<Eigen::Index>(i - begin)) = room.point[i].transpose();
        radius += room.radius[i] / static_cast<double>(end - begin);
      }
      run.radius = radius;
      run.edgeLength = 2.0 * radius / kTetsAcross;
      out.push_back(std::move(run));
    }
  }
  return out;
}

Result<void> checkProject(const model::Project& project) {
  const auto fault = model::findFault(project);
  if (!fault) return {};
  return fail(fault->code, fault->message, {.object = fault->object});
}

}  // namespace

Result<domain::DomainBuild> buildDomainOf(const model::Project& project,
                                          const ProjectMeshes& meshes, const BuildOptions& options,
                                          RunContext& run) {
  domain::DomainInput input;
  input.skin = meshes.skin;
  input.bones = meshes.bones;
  input.obstacles = meshes.obstacles;
  input.cavities = meshes.cavities;
  input.cutPlanes = cutPlanes(project);
  input.curves = sizingCurves(curveTissues(project), meshes.skin);

  domain::DomainOptions how;
  how.surfaceToleranceRel = project.settings.surfaceTolerance;
  how.tets = options.edgeLength ? std::nullopt
             : options.tets     ? options.tets
                                : project.settings.tets;
  how.edgeLength = options.edgeLength ? options.edgeLength : project.settings.edgeLength;
  how.useCache = options.useCache;
  return domain::buildDomain(input, how, run);
}

Result<PreparedDomain> prepareDomain(const model::Project& project, const BuildOptions& options,
                                     RunContext& run) {
  auto meshes = loadMeshes(project, run);
  if (!meshes) return passOn(meshes);
  auto built = buildDomainOf(project, *meshes, options, run);
  if (!built) return passOn(built);
  return PreparedDomain{std::move(*meshes), std::move(*built)};
}

Result<Build> build(const model::Project& project, const BuildOptions& options, RunContext& run) {
  if (auto sound = checkProject(project); !sound) return passOn(sound);
  auto prepared = prepareDomain(project, options, run);
  if (!prepared) return passOn(prepared);

  Build out;
  out.meshes = std::move(prepared->meshes);
  out.domain = std::move(prepared->build);
  out.tissues = curveTissues(project);
  const domain::Domain& domain = out.domain.domain;

  tissue::TissueOptions how = tissueOptions(project);
  if (options.alpha) how.alpha = options.alpha;
  {
    auto cores = tissue::traceCurves(domain, out.tissues, how, run);
    if (!cores) return passOn(cores);
    out.cores = std::move(*cores);
    auto fields = tissue::solveTissueFields(domain, out.cores, out.tissues, how, run);
    if (!fields) return passOn(fields);
    out.fields = std::move(*fields);
  }
  {
    envelope::EnvelopeOptions cut;
    cut.exact = options.exact;
    auto anatomy = envelope::buildAnatomy(domain, out.fields, out.cores, cut, run);
    if (!anatomy) return passOn(anatomy);
    out.anatomy = std::move(anatomy->anatomy);
    out.envelopeStats = std::move(anatomy->stats);
  }
  {
    const Stage stage(run, "surfaces");
    std::vector<std::string> names{"fat"};
    for (const auto& tissue : out.tissues) names.push_back(tissue.name);
    out.surfaces = envelope::tissueSurfaces(out.anatomy, names);
    out.measures = envelope::measureTissues(out.anatomy, names.size());
  }
  {
    // One muscle that its neighbours pinch off from an end must not cost the user the other forty
    const fiber::FiberOptions flow{.unendedPiece = fiber::UnendedPiece::FollowCurve};
    auto fibers =
        fiber::computeFibers(out.anatomy, domain, out.tissues, muscleEnds(project), flow, run);
    if (!fibers) return passOn(fibers);
    out.fibers = std::move(*fibers);
  }
  return out;
}

std::vector<double> tissueVolumes(const Build& build) {
  std::vector<double> out;
  for (std::size_t i = 1; i < build.measures.size(); ++i) out.push_back(build.measures[i].volume);
  return out;
}

}  // namespace ecorche::engine
