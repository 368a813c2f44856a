#include <ecorche/domain/interior_points.h>
#include <ecorche/engine/build.h>
#include <ecorche/engine/curve_room.h>
#include <ecorche/engine/draft.h>
#include <ecorche/model/project_check.h>
#include <ecorche/tissue/solve_tissues.h>

#include <algorithm>
#include <cmath>

namespace ecorche::engine {

namespace {

/// The machine's fault or the user's wish: what costs a draft its end costs the domain its own.
bool meetsTheDomainToo(ErrorCode code) {
  switch (code) {
    case ErrorCode::Cancelled:
    case ErrorCode::FileNotWritable:
    case ErrorCode::OutOfMemory:
    case ErrorCode::WorkerMissing:
    case ErrorCode::WorkerTimedOut:
      return true;
    default:
      return false;
  }
}

/// Where tets should be small. What a draft cannot answer is left to the guess that it began with,
/// and the report says so: input that is at fault is for the domain itself to refuse.
Result<std::vector<domain::WantedLength>> wantedLengths(const model::Project& project,
                                                        const domain::DomainInput& input,
                                                        const domain::DomainOptions& how,
                                                        Findings& findings, RunContext& run) {
  const auto tissues = curveTissues(project);
  auto lengths = lengthsFromDraft(input, how, tissues, tissueOptions(project), run);
  if (lengths || meetsTheDomainToo(lengths.error().code)) return lengths;
  findings.push_back(
      {.severity = Severity::Warning,
       .kind = "no-draft",
       .message = "tets are sized by a guess from the curves alone: " + lengths.error().message});
  return input.lengths;
}

/// How many tets are asked for, one way or the other.
std::int64_t tetsAskedFor(const domain::DomainOptions& how, const mesh::SurfaceMesh& skin) {
  if (how.tets) return *how.tets;
  if (!how.edgeLength) return domain::kDefaultTets;
  const double volume = std::abs(mesh::signedVolume(skin.V, skin.F));
  return static_cast<std::int64_t>(
      std::min(1e9, volume / domain::latticeTetVolume(*how.edgeLength)));
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
  if (options.sizing != Sizing::None)
    input.lengths = lengthsAlongCurves(curveTissues(project), meshes.skin);

  domain::DomainOptions how;
  how.surfaceToleranceRel = project.settings.surfaceTolerance;
  how.tets = options.edgeLength ? std::nullopt
             : options.tets     ? options.tets
                                : project.settings.tets;
  how.edgeLength = options.edgeLength ? options.edgeLength : project.settings.edgeLength;
  how.useCache = options.useCache;
  how.workerTimeout = options.mesherTimeout;
  const auto muscles = std::ssize(curveTissuePlaces(project));
  std::int64_t faces = meshes.skin.F.rows();
  for (const auto* list : {&meshes.bones, &meshes.obstacles, &meshes.cavities}) {
    for (const auto& m : *list) faces += m.F.rows();
  }
  const Estimate estimate = estimateBuild(tetsAskedFor(how, meshes.skin), muscles, faces);
  if (options.onEstimate) options.onEstimate(estimate);
  if (auto enough = requireMemory(estimate, muscles, faces); !enough) return passOn(enough);
  Findings findings = meshes.findings;
  findings.push_back(
      {.severity = Severity::Note,
       .kind = "estimate",
       .message = "before it began, the build was estimated to take " + estimate.text(),
       .size = static_cast<double>(estimate.memoryBytes)});
  if (options.sizing == Sizing::Draft && !options.lengths.empty()) {
    input.lengths = options.lengths;
  } else if (options.sizing == Sizing::Draft) {
    auto lengths = wantedLengths(project, input, how, findings, run);
    if (!lengths) return passOn(lengths);
    input.lengths = std::move(*lengths);
  }
  if (options.sizing != Sizing::None) {
    const auto close =
        lengthsBetweenCurves(curveTissues(project), mesh::boundingBox(input.skin).diagonal());
    input.lengths.insert(input.lengths.end(), close.begin(), close.end());
  }
  auto built = domain::buildDomain(input, how, run);
  if (built) {
    auto& all = built->report.findings;
    all.insert(all.begin(), findings.begin(), findings.end());
  }
  return built;
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
  if (auto sound = model::checkProject(project); !sound) return passOn(sound);
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
    auto solved = tissue::solveTissues(domain, out.tissues, how, run);
    if (!solved) return passOn(solved);
    out.cores = std::move(solved->cores);
    out.fields = std::move(solved->fields);
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
    const auto names = fieldNames(out.tissues);
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
