#include <ecorche/domain/build_domain.h>
#include <ecorche/domain/carve.h>
#include <ecorche/domain/deviation.h>
#include <ecorche/domain/domain_cache.h>
#include <ecorche/domain/fill_with_tets.h>
#include <ecorche/domain/finish_domain.h>
#include <ecorche/domain/interior_points.h>
#include <ecorche/domain/prepare_meshes.h>
#include <ecorche/domain/sizing_field.h>
#include <ecorche/domain/wall_resampling.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ecorche::domain {

namespace {

using mesh::Vector3;

constexpr double kWrapShare = 0.5;  // of the tolerance, for wraps; resampling needs the rest
// Of the diagonal of the uncut skin, before lengths are scaled to the budget
constexpr double kCoarsest = 0.02;
constexpr double kFinest = 0.0002;
constexpr double kFinestGap = 0.0008;

/// As many tets as a lattice of this mean edge has in the volume.
double tetsOfEdge(double edge, const TaggedSurface& walls) {
  return mesh::signedVolume(walls.V, walls.F) / latticeTetVolume(edge);
}

struct Filling {
  TaggedSurface walls;
  mesh::Positions points;
  double scale = 1.0;
};

/// The scale at which walls and points together use the budget up, from what they were at
/// `out.scale` (points) and `wallScale`: points go with its cube, walls with less than its square,
/// since where they bend the tolerance decides.
double balancedScale(const Filling& out, double wallScale, double budget) {
  constexpr double kWallPower = 1.0;
  const auto tets = [&](double scale) {
    return tetsOf(out.points.rows(), 0) * std::pow(out.scale / scale, 3.0) +
           tetsOf(0, out.walls.F.rows()) * std::pow(wallScale / scale, kWallPower);
  };
  double lo = 0.1 * wallScale;
  double hi = 10.0 * wallScale;
  for (int step = 0; step < 40; ++step) {
    const double middle = std::sqrt(lo * hi);
    (tets(middle) > budget ? lo : hi) = middle;
  }
  return hi;
}

/// Resampled walls and points between them. The first guess of the scale is put right where points
/// and walls, once counted, lead elsewhere: points alone where that is enough, walls too where
/// their triangles would no longer match the tets.
Result<Filling> fillWalls(const TaggedSurface& surface, const std::vector<CutPlane>& cutPlanes,
                          const SizingField& sizing, double scale, std::optional<double> budget,
                          double tolerance, RunContext& run) {
  constexpr double kClose = 0.03;     // of the budget: near enough
  constexpr double kMismatch = 0.12;  // of the scale, between walls and tets
  constexpr double kCoarser =
      1.4;  // than the walls: more would make needles of the tets beside them
  constexpr int kTrials = 4;
  Filling out;
  for (int attempt = 0;; ++attempt) {
    auto resampled = resampleWalls(surface, cutPlanes, sizing, scale, tolerance, run);
    if (!resampled) return passOn(resampled);
    out.walls = std::move(resampled->walls);
    out.scale = scale;

    const Stage stage(run, "domain: inner points");
    for (int trial = 0;; ++trial) {
      out.points = interiorPoints(out.walls, sizing, out.scale);
      if (!budget) return out;
      const double left = *budget - tetsOf(0, out.walls.F.rows());
      const double now = tetsOf(out.points.rows(), 0);
      if (trial == kTrials || std::abs(now - left) < kClose * *budget || run.cancelled()) break;
      // Walls alone may use the budget up
      const double factor = left > 0.0 ? std::cbrt(now / left) : kCoarser;
      const double next = std::clamp(out.scale * factor, scale / kCoarser, scale * kCoarser);
      if (next == out.scale) break;
      out.scale = next;
    }
    if (attempt == 2 || std::abs(std::log(out.scale / scale)) < kMismatch) return out;
    scale = balancedScale(out, scale, *budget);
  }
}

// Where the promise cannot be kept the report says so, surface by surface
void reportExcess(DomainReport& report) {
  for (const SurfaceDeviation& d : report.deviations) {
    const double far = std::max(d.maxFromInput, d.maxToInput);
    if (far <= report.tolerance) continue;
    report.findings.push_back(
        {.severity = Severity::Warning,
         .kind = "deviation",
         .object = d.name,
         .message = fmt::format(
             "\"{}\" and the domain are up to {:.3g} mm apart; {:.3g} mm were asked for", d.name,
             far * 1e3, report.tolerance * 1e3),
         .size = far});
  }
}

}  // namespace

Result<DomainBuild> buildDomain(const DomainInput& input, const DomainOptions& options,
                                RunContext& run) {
  const bool sane = options.surfaceToleranceRel > 0.0 && options.surfaceToleranceRel < 0.1 &&
                    options.gradation >= 0.0 && (!options.tets || *options.tets >= 1000) &&
                    (!options.edgeLength || *options.edgeLength > 0.0);
  if (!sane) {
    return fail(ErrorCode::ValueOutOfRange,
                "tets must be 1000 or more, an edge length above 0, the surface tolerance between "
                "0 and 0.1 of the diagonal");
  }
  DomainBuild out;
  const std::string key = options.useCache ? cacheKey(input, options) : std::string();
  Findings cacheFindings;
  if (options.useCache) {
    const Stage stage(run, "domain: cache");
    if (auto cached = loadCached(key, cacheFindings)) return std::move(*cached);
  }

  // 1, 2. Check and repair
  auto prepared = prepareMeshes(input, kWrapShare * options.surfaceToleranceRel, run);
  if (!prepared) return passOn(prepared);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while repairing meshes");
  const double diagonal = mesh::boundingBox(prepared->carve.skin).diagonal();
  const double tolerance = options.surfaceToleranceRel * diagonal;
  out.report.tolerance = tolerance;
  out.report.findings = std::move(prepared->findings);

  // 4, 5. Unite bones, subtract, clip
  auto carved = carve(prepared->carve, {.wrapTolerance = kWrapShare * tolerance}, run);
  if (!carved) return passOn(carved);
  out.report.findings.insert(out.report.findings.end(), carved->findings.begin(),
                             carved->findings.end());
  out.report.wraps = carved->wrapCount;
  out.report.bonesLeftOut = std::ranges::count_if(carved->leftOut, [&](std::size_t hole) {
    return prepared->carve.holes[hole].tag.kind == BoundaryTag::Kind::Bone;
  });
  out.report.bonesUsed = prepared->bones - out.report.bonesLeftOut;

  // Sizing: lengths wanted by curves and gaps, all scaled to the budget
  std::optional<double> budget;
  if (!options.edgeLength || options.tets) {
    out.report.requestedTets = options.tets.value_or(kDefaultTets);
    budget = static_cast<double>(out.report.requestedTets);
  }
  const double coarsest = kCoarsest * diagonal;
  std::optional<SizingField> sizing;
  double scale = 1.0;
  {
    const Stage stage(run, "domain: sizing");
    auto lengths = lengthsInGaps(carved->surface, kFinestGap * diagonal, coarsest);
    for (const WantedLength& w : input.lengths)
      lengths.push_back({w.point, std::clamp(w.length, kFinest * diagonal, coarsest)});
    sizing.emplace(mesh::boundingBox(carved->surface.V), lengths, coarsest, options.gradation);
    const TetEstimate estimate(carved->surface, *sizing);
    // A given edge length is that of the lattice that fills the same volume with as many tets
    scale = estimate.scaleFor(budget ? *budget : tetsOfEdge(*options.edgeLength, carved->surface));
  }
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while sizing the domain");

  // 3. Resample to the wanted lengths, and fill to the budget
  auto filling =
      fillWalls(carved->surface, prepared->carve.cutPlanes, *sizing, scale, budget, tolerance, run);
  if (!filling) return passOn(filling);
  const TaggedSurface& walls = filling->walls;
  const mesh::Positions& points = filling->points;
  scale = filling->scale;

  // 6. Tets
  Domain frame;
  for (const auto& bone : input.bones) frame.boneNames.push_back(bone.name);
  for (const auto& plane : input.cutPlanes) frame.cutPlaneNames.push_back(plane.name);
  frame.skinDiagonal = diagonal;
  const FillTask task{walls,   points, carved->surface, prepared->carve.cutPlanes, frame.boneNames,
                      *sizing, scale,  tolerance,       options.workerTimeout};
  auto tets = fillWithTets(task, run);
  if (!tets) return passOn(tets);
  out.report.mesher = tets->mesher;
  out.report.fallback = tets->fallback;
  out.report.fallbackReason = tets->fallbackReason;
  out.report.findings.insert(out.report.findings.end(), tets->findings.begin(),
                             tets->findings.end());
  const TaggedSurface& filled = tets->ofWalls ? walls : carved->surface;

  // 7. Verify
  DomainReport verified = out.report;
  auto domain = finishDomain(std::move(tets->tets), filled, frame, verified, run);
  if (!domain && domain.error().code == ErrorCode::MeshingFailed && tets->ofWalls) {
    // Pieces smaller than the tolerance may have been resampled to nothing; before that they are
    // sound
    verified = out.report;
    verified.findings.push_back(
        {.severity = Severity::Warning,
         .kind = "full-density",
         .object = input.skin.name,
         .message = fmt::format("resampled walls made no sound domain ({}), so it was made from "
                                "walls at their full density",
                                domain.error().message)});
    const mesh::Positions inner = interiorPoints(carved->surface, *sizing, scale);
    const FillTask dense{carved->surface,      inner,   carved->surface, prepared->carve.cutPlanes,
                         frame.boneNames,      *sizing, scale,           tolerance,
                         options.workerTimeout};
    auto again = fillWithTets(dense, run);
    if (!again) return passOn(again);
    domain = finishDomain(std::move(again->tets), carved->surface, frame, verified, run);
  }
  if (!domain) return passOn(domain);
  out.report = std::move(verified);
  out.domain = std::move(*domain);
  out.report.deviations = measureDeviations(out.domain, *carved, prepared->carve, tolerance, run);
  for (const SurfaceDeviation& d : out.report.deviations) {
    out.report.maxDeviation = std::max({out.report.maxDeviation, d.maxFromInput, d.maxToInput});
  }
  if (out.report.maxDeviation > tolerance) reportExcess(out.report);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while measuring the domain");
  if (options.useCache) storeCached(key, out);
  // What befell the cache is no news to those who get this domain from it
  out.report.findings.insert(out.report.findings.begin(), cacheFindings.begin(),
                             cacheFindings.end());
  return out;
}

}  // namespace ecorche::domain
