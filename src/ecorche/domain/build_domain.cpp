#include <ecorche/core/byte_stream.h>
#include <ecorche/core/files.h>
#include <ecorche/core/parallel.h>
#include <ecorche/core/subprocess.h>
#include <ecorche/domain/build_domain.h>
#include <ecorche/domain/carve.h>
#include <ecorche/domain/domain_cache.h>
#include <ecorche/domain/finish_domain.h>
#include <ecorche/domain/interior_points.h>
#include <ecorche/domain/resample.h>
#include <ecorche/domain/sizing_field.h>
#include <ecorche/domain/tet_files.h>
#include <ecorche/domain/triangle_tree.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_repair.h>
#include <ecorche/mesh/surface_topology.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

namespace ecorche::domain {

namespace {

using mesh::Vector3;

// Beside the walls TetGen needs more tets than the lattice alone would; measured on limbs of 120 k
// to 1.5 M tets
constexpr double kWallFactor = 1.0;
constexpr std::int64_t kDefaultTets = 200000;
// Walls kept as they are, angles and radius-edge ratios of tets bounded
constexpr const char* kTetgenSwitches = "pq1.6/10YQ";
// The same with walls that may be split
constexpr const char* kTetgenLooser = "pq1.6/10Q";

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
                            const char* switches, const DomainOptions& options, RunContext& run) {
  const Stage stage(run, "domain: tets");
  auto scratch = ScratchFolder::create();
  if (!scratch) return passOn(scratch);
  TetRequest request;
  request.surface = walls;
  request.points = points;
  request.holes = pointsInVoids(walls);
  request.switches = switches;
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

// Farthest and mean distance of a surface's vertices and face centres from another
void measure(const mesh::Positions& V, const mesh::Triangles& F,
             const std::vector<Eigen::Index>& faces, const mesh::SurfaceQuery& to, double& largest,
             double& mean) {
  std::vector<double> distance(faces.size() * 4, 0.0);
  parallelFor(
      static_cast<std::int64_t>(faces.size()),
      [&](std::int64_t i) {
        const Eigen::Index f = faces[static_cast<std::size_t>(i)];
        Vector3 centre = Vector3::Zero();
        for (int c = 0; c < 3; ++c) {
          const Vector3 p = V.row(F(f, c)).transpose();
          distance[static_cast<std::size_t>(4 * i + c)] = to.distance(p);
          centre += p / 3.0;
        }
        distance[static_cast<std::size_t>(4 * i + 3)] = to.distance(centre);
      },
      64);
  largest = 0.0;
  double sum = 0.0;
  for (const double d : distance) {
    largest = std::max(largest, d);
    sum += d;
  }
  mean = distance.empty() ? 0.0 : sum / static_cast<double>(distance.size());
}

// Both ways, on what is exposed: the carved surface is what is left of the inputs where none hides
// another
void measureDeviations(const Domain& domain, const TaggedSurface& carved, const CarveInput& input,
                       DomainReport& report, RunContext& run) {
  const Stage stage(run, "domain: deviation");
  const mesh::SurfaceQuery toDomain(domain.mesh.V, domain.boundaryF);
  std::map<BoundaryTag, std::vector<Eigen::Index>> domainFaces;
  for (std::size_t b = 0; b < domain.boundaryTag.size(); ++b)
    domainFaces[domain.boundaryTag[b]].push_back(static_cast<Eigen::Index>(b));
  std::map<BoundaryTag, std::vector<Eigen::Index>> carvedFaces;
  for (std::size_t f = 0; f < carved.tag.size(); ++f)
    carvedFaces[unpacked(carved.tag[f])].push_back(static_cast<Eigen::Index>(f));

  const auto look = [&](BoundaryTag tag, const std::string& name,
                        const mesh::SurfaceMesh& original) {
    const auto faces = domainFaces.find(tag);
    if (faces == domainFaces.end()) return;
    SurfaceDeviation d;
    d.name = name;
    const mesh::SurfaceQuery toOriginal(original);
    measure(domain.mesh.V, domain.boundaryF, faces->second, toOriginal, d.maxToInput,
            d.meanToInput);
    measure(carved.V, carved.F, carvedFaces[tag], toDomain, d.maxFromInput, d.meanFromInput);
    report.maxDeviation = std::max({report.maxDeviation, d.maxToInput, d.maxFromInput});
    report.deviations.push_back(std::move(d));
  };
  look({BoundaryTag::Kind::Skin, 0}, "skin", input.skin);
  for (const Hole& hole : input.holes) look(hole.tag, hole.name, hole.mesh);
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
  auto carved = carve(prepared->carve, {.wrapTolerance = 0.5 * tolerance}, run);
  if (!carved) return passOn(carved);
  out.report.findings.insert(out.report.findings.end(), carved->findings.begin(),
                             carved->findings.end());
  out.report.wraps = carved->wrapCount;
  const auto leftOut = static_cast<std::int64_t>(carved->leftOut.size());
  out.report.bonesLeftOut = std::min(leftOut, prepared->bones);
  out.report.bonesUsed = prepared->bones - out.report.bonesLeftOut;

  // Sizing: lengths wanted by curves and gaps, all scaled to the budget
  const mesh::Box box = mesh::boundingBox(carved->surface.V);
  double scale = 1.0;
  std::optional<SizingField> sizing;
  {
    const Stage stage(run, "domain: sizing");
    const double finest = 0.0008 * diagonal;
    const double coarsest = 0.02 * diagonal;
    const mesh::SurfaceQuery walls(carved->surface.V, carved->surface.F);
    sizing.emplace(box, sizingSources(input.curves, carved->surface, finest, coarsest), coarsest,
                   options.gradation);
    if (options.edgeLength && !options.tets) {
      // Mean wanted length over the volume becomes the given one
      const TetEstimate estimate(walls, *sizing);
      const double cell = *options.edgeLength / 0.92;
      scale = estimate.scaleFor(12.0 * mesh::signedVolume(carved->surface.V, carved->surface.F) /
                                (cell * cell * cell));
    } else {
      const auto wanted = static_cast<double>(options.tets.value_or(kDefaultTets));
      out.report.requestedTets = options.tets.value_or(kDefaultTets);
      scale = TetEstimate(walls, *sizing).scaleFor(wanted / kWallFactor);
    }
  }
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while sizing the domain");

  // 3. Resample to the wanted lengths. Half the tolerance: tips that resampling cuts off are seen
  // only from the other side, and what is left pays for them.
  TaggedSurface walls;
  {
    const Stage stage(run, "domain: resample");
    ResampleOptions how;
    how.edgeLength = [&](const Vector3& p) { return scale * sizing->at(p); };
    how.tolerance = [&](const Vector3&) { return 0.7 * tolerance; };
    auto resampled = resample(carved->surface, input.cutPlanes, how, run);
    if (!resampled && resampled.error().code != ErrorCode::MeshNotRepairable)
      return passOn(resampled);
    if (!resampled) {
      out.report.findings.push_back(
          {Severity::Warning, "not-resampled", "domain",
           resampled.error().message + "; the walls keep their full density"});
    }
    walls = resampled ? std::move(*resampled) : carved->surface;
  }

  // 6. Tets
  mesh::Positions points;
  {
    const Stage stage(run, "domain: inner points");
    points = interiorPoints(mesh::SurfaceQuery(walls.V, walls.F), *sizing, scale);
  }
  // Resampling can make walls cut one another where they are close; the carved walls themselves do
  // not
  struct Attempt {
    const TaggedSurface* walls;
    const char* switches;
    const char* what;
  };
  const Attempt attempts[] = {
      {&walls, kTetgenSwitches, "resampled walls"},
      {&carved->surface, kTetgenSwitches, "walls at their full density"},
      {&carved->surface, kTetgenLooser, "walls at their full density, split where needed"}};
  Result<TetAnswer> answer;
  const TaggedSurface* filled = nullptr;
  for (const Attempt& attempt : attempts) {
    answer = runTetgen(*attempt.walls, points, attempt.switches, options, run);
    filled = attempt.walls;
    if (answer) break;
    const ErrorCode code = answer.error().code;
    if (code != ErrorCode::WorkerCrashed && code != ErrorCode::MeshingFailed) return passOn(answer);
    out.report.findings.push_back(
        {Severity::Warning, "mesher-refused", "domain",
         fmt::format("TetGen refused {}: {}", attempt.what, answer.error().message)});
  }
  if (!answer) return passOn(answer);
  out.report.mesher = "TetGen";

  // 7. Verify
  Domain frame;
  for (const auto& bone : input.bones) frame.boneNames.push_back(bone.name);
  for (const auto& plane : input.cutPlanes) frame.cutPlaneNames.push_back(plane.name);
  frame.skinDiagonal = diagonal;
  auto domain = finishDomain(std::move(*answer), *filled, std::move(frame), out.report, run);
  if (!domain) return passOn(domain);
  out.domain = std::move(*domain);
  measureDeviations(out.domain, carved->surface, prepared->carve, out.report, run);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while measuring the domain");
  if (options.useCache) storeCached(key, out);
  return out;
}

}  // namespace ecorche::domain
