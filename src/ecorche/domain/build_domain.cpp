#include <ecorche/core/byte_stream.h>
#include <ecorche/core/files.h>
#include <ecorche/core/parallel.h>
#include <ecorche/core/subprocess.h>
#include <ecorche/domain/build_domain.h>
#include <ecorche/domain/carve.h>
#include <ecorche/domain/deviation.h>
#include <ecorche/domain/domain_cache.h>
#include <ecorche/domain/fill_mesh_3.h>
#include <ecorche/domain/finish_domain.h>
#include <ecorche/domain/interior_points.h>
#include <ecorche/domain/sizing_field.h>
#include <ecorche/domain/tet_files.h>
#include <ecorche/domain/triangle_tree.h>
#include <ecorche/domain/wall_resampling.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_repair.h>
#include <ecorche/mesh/surface_topology.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace ecorche::domain {

namespace {

using mesh::Vector3;

constexpr std::int64_t kDefaultTets = 200000;
constexpr double kWrapShare = 0.5;  // of the tolerance, for wraps; resampling needs the rest
constexpr const char* kTetgenSwitches = "pq1.6/10YQ";

struct Prepared {
  CarveInput carve;
  Findings findings;
  std::int64_t bones = 0;
};

bool beyondAPlane(const mesh::SurfaceMesh& mesh, const std::vector<CutPlane>& planes) {
  return std::ranges::any_of(planes, [&](const CutPlane& plane) {
    for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
      if (plane.normal.dot(mesh.V.row(v).transpose() - plane.point) > 0.0) return false;
    }
    return true;
  });
}

// Steps 1 and 2: check, repair what is certain
Result<Prepared> prepare(const DomainInput& input, RunContext& run) {
  const Stage stage(run, "domain: check and repair");
  Prepared out;
  auto skin = mesh::repairSurface(input.skin, {.mustClose = true}, run);
  if (!skin) return passOn(skin);
  out.findings = std::move(skin->findings);
  out.carve.skin = std::move(skin->mesh);
  out.carve.cutPlanes = input.cutPlanes;
  for (CutPlane& plane : out.carve.cutPlanes) plane.normal.normalize();

  struct Wanted {
    const mesh::SurfaceMesh* mesh;
    BoundaryTag tag;
  };
  std::vector<Wanted> wanted;
  const auto add = [&](const std::vector<mesh::SurfaceMesh>& list, BoundaryTag::Kind kind) {
    for (std::size_t i = 0; i < list.size(); ++i)
      wanted.push_back({&list[i], {kind, static_cast<std::int32_t>(i)}});
  };
  add(input.bones, BoundaryTag::Kind::Bone);
  add(input.obstacles, BoundaryTag::Kind::Obstacle);
  add(input.cavities, BoundaryTag::Kind::Cavity);
  std::vector<Result<mesh::RepairedSurface>> repaired(wanted.size());
  std::vector<std::uint8_t> fit(wanted.size(), 0);
  parallelFor(
      static_cast<std::int64_t>(wanted.size()),
      [&](std::int64_t i) {
        const auto k = static_cast<std::size_t>(i);
        if (beyondAPlane(*wanted[k].mesh, input.cutPlanes)) {
          repaired[k] = mesh::RepairedSurface{*wanted[k].mesh, {}};
          return;
        }
        repaired[k] = mesh::repairSurface(*wanted[k].mesh, {}, run);
        if (!repaired[k]) return;
        const mesh::SurfaceCheck check =
            mesh::checkSurface(repaired[k]->mesh, {.selfIntersections = true});
        fit[k] = check.isSound() && check.selfIntersections.value_or(0) == 0;
      },
      1);
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    if (!repaired[k]) return passOn(repaired[k]);
    out.findings.insert(out.findings.end(), repaired[k]->findings.begin(),
                        repaired[k]->findings.end());
    out.carve.holes.push_back(
        {wanted[k].mesh->name, std::move(repaired[k]->mesh), wanted[k].tag, fit[k] != 0});
    out.bones += wanted[k].tag.kind == BoundaryTag::Kind::Bone;
  }
  return out;
}

// A point in every void: TetGen fills whatever a closed wall encloses unless it is told where not
// to. From the middle of a void's wall straight into it, half-way to the next wall.
mesh::Positions pointsInVoids(const TaggedSurface& walls) {
  const mesh::FaceComponents pieces = mesh::components(walls.F);
  std::vector<double> volume(static_cast<std::size_t>(pieces.count), 0.0);
  std::vector<double> largest(volume.size(), 0.0);
  std::vector<Eigen::Index> face(volume.size(), -1);
  const Vector3 origin = walls.V.colwise().mean().transpose();
  for (Eigen::Index f = 0; f < walls.F.rows(); ++f) {
    const auto c = static_cast<std::size_t>(pieces.label[static_cast<std::size_t>(f)]);
    const Vector3 a = walls.V.row(walls.F(f, 0)).transpose() - origin;
    const Vector3 b = walls.V.row(walls.F(f, 1)).transpose() - origin;
    const Vector3 d = walls.V.row(walls.F(f, 2)).transpose() - origin;
    volume[c] += a.dot(b.cross(d)) / 6.0;
    const double area = (b - a).cross(d - a).norm();
    if (area > largest[c]) {
      largest[c] = area;
      face[c] = f;
    }
  }
  const TriangleTree tree(walls.V, walls.F);
  std::vector<Vector3> points;
  for (std::size_t c = 0; c < volume.size(); ++c) {
    if (volume[c] >= 0.0 || face[c] < 0) continue;
    const Vector3 a = walls.V.row(walls.F(face[c], 0)).transpose();
    const Vector3 b = walls.V.row(walls.F(face[c], 1)).transpose();
    const Vector3 d = walls.V.row(walls.F(face[c], 2)).transpose();
    const Vector3 out = (b - a).cross(d - a).normalized();
    const Vector3 from = (a + b + d) / 3.0;
    const double edge = std::sqrt(largest[c]);
    const auto hit = tree.firstHit(from, out, 1e-6 * edge, 1e3 * edge);
    if (hit) points.push_back(from + 0.5 * *hit * out);
  }
  mesh::Positions holes(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i)
    holes.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  return holes;
}

Result<TetAnswer> runTetgen(const TaggedSurface& walls, const mesh::Positions& points,
                            const DomainOptions& options, RunContext& run) {
  const Stage stage(run, "domain: tets");
  auto scratch = ScratchFolder::create();
  if (!scratch) return passOn(scratch);
  TetRequest request;
  request.surface = walls;
  request.points = points;
  request.holes = pointsInVoids(walls);
  request.switches = kTetgenSwitches;
  const auto in = scratch->path() / "request";
  const auto out = scratch->path() / "answer";
  if (auto written = writeFileWhole(in, encodeTetRequest(request)); !written)
    return passOn(written);
  auto done = runWorker({"tetrahedralize", in.string(), out.string()},
                        {.timeout = options.workerTimeout}, run);
  if (!done) return passOn(done);
  auto bytes = readFile(out);
  if (!bytes) return passOn(bytes);
  return decodeTetAnswer(*bytes);
}

/// As many tets as a lattice of this mean edge has in the volume.
double tetsOfEdge(double edge, const TaggedSurface& walls) {
  return mesh::signedVolume(walls.V, walls.F) / latticeTetVolume(edge);
}

struct Filling {
  TaggedSurface walls;
  mesh::Positions points;
  double scale = 1.0;
};

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
    scale = out.scale;
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
  auto prepared = prepare(input, run);
  if (!prepared) return passOn(prepared);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while repairing meshes");
  const mesh::Box skinBox = mesh::boundingBox(prepared->carve.skin);
  const double diagonal = skinBox.diagonal();
  const double tolerance = options.surfaceToleranceRel * diagonal;
  out.report.tolerance = tolerance;
  out.report.findings = std::move(cacheFindings);
  out.report.findings.insert(out.report.findings.end(), prepared->findings.begin(),
                             prepared->findings.end());

  // 4, 5. Unite bones, subtract, clip
  auto carved = carve(prepared->carve, {.wrapTolerance = kWrapShare * tolerance}, run);
  if (!carved) return passOn(carved);
  out.report.findings.insert(out.report.findings.end(), carved->findings.begin(),
                             carved->findings.end());
  out.report.wraps = carved->wrapCount;
  const auto leftOut = static_cast<std::int64_t>(carved->leftOut.size());
  out.report.bonesLeftOut = std::min(leftOut, prepared->bones);
  out.report.bonesUsed = prepared->bones - out.report.bonesLeftOut;

  // Sizing: lengths wanted by curves and gaps, all scaled to the budget
  std::optional<double> budget;
  if (!options.edgeLength || options.tets) {
    out.report.requestedTets = options.tets.value_or(kDefaultTets);
    budget = static_cast<double>(out.report.requestedTets);
  }
  const double coarsest = 0.02 * diagonal;
  std::optional<SizingField> sizing;
  double scale = 1.0;
  {
    const Stage stage(run, "domain: sizing");
    const double finest = 0.0008 * diagonal;
    sizing.emplace(mesh::boundingBox(carved->surface.V),
                   sizingSources(input.curves, carved->surface, finest, coarsest), coarsest,
                   options.gradation);
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
  auto answer = runTetgen(walls, points, options, run);
  const TaggedSurface* filled = &walls;
  out.report.mesher = "TetGen";
  const auto refused = [&] {
    return !answer && (answer.error().code == ErrorCode::MeshingFailed ||
                       answer.error().code == ErrorCode::WorkerCrashed);
  };
  if (refused()) {
    out.report.findings.push_back(
        {.severity = Severity::Warning,
         .kind = "mesher-refused",
         .object = "domain",
         .message = fmt::format(
             "TetGen refused the resampled walls ({}); it was given walls at their full density",
             answer.error().message)});
    answer = runTetgen(carved->surface, points, options, run);
    filled = &carved->surface;
  }
  if (refused()) {
    out.report.mesher = "CGAL Mesh_3";
    out.report.fallback = true;
    out.report.fallbackReason = answer.error().message;
    out.report.findings.push_back(
        {.severity = Severity::Warning,
         .kind = "fallback",
         .object = "domain",
         .message = fmt::format(
             "TetGen refused the domain ({}); it was filled by CGAL Mesh_3, which makes the "
             "surface anew and rounds its edges",
             out.report.fallbackReason)});
    answer = fillByMesh3(
        carved->surface, prepared->carve.cutPlanes,
        [&](const Vector3& p) { return scale * sizing->at(p); }, 0.5 * tolerance, run);
  }
  if (!answer) return passOn(answer);

  // 7. Verify
  Domain frame;
  for (const auto& bone : input.bones) frame.boneNames.push_back(bone.name);
  for (const auto& plane : input.cutPlanes) frame.cutPlaneNames.push_back(plane.name);
  frame.skinDiagonal = diagonal;
  auto domain = finishDomain(std::move(*answer), *filled, std::move(frame), out.report, run);
  if (!domain) return passOn(domain);
  out.domain = std::move(*domain);
  out.report.deviations = measureDeviations(out.domain, *carved, prepared->carve, tolerance, run);
  for (const SurfaceDeviation& d : out.report.deviations) {
    out.report.maxDeviation = std::max({out.report.maxDeviation, d.maxFromInput, d.maxToInput});
  }
  if (out.report.maxDeviation > tolerance) reportExcess(out.report);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while measuring the domain");
  if (options.useCache) storeCached(key, out);
  return out;
}

}  // namespace ecorche::domain
