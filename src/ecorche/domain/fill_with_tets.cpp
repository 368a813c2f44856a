#include <ecorche/core/files.h>
#include <ecorche/core/subprocess.h>
#include <ecorche/domain/fill_with_tets.h>
#include <ecorche/domain/triangle_tree.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_topology.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

namespace ecorche::domain {

namespace {

using mesh::Vector3;

constexpr const char* kTetgenSwitches = "pq1.6/10YQ";

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

Result<TetAnswer> askWorker(const char* subcommand, const std::string& request, double timeout,
                            RunContext& run) {
  auto scratch = ScratchFolder::create();
  if (!scratch) return passOn(scratch);
  const auto in = scratch->path() / "request";
  const auto out = scratch->path() / "answer";
  // A full disk is that of temporary files, wherever the user's own are
  const auto ofScratch = [&](Error error) {
    if (error.code == ErrorCode::FileNotWritable) {
      error.place.file = scratch->path().string();
      error.message += "; TMPDIR names the folder of temporary files";
    }
    return tl::unexpected(std::move(error));
  };
  if (auto written = writeFileWhole(in, request); !written) return ofScratch(written.error());
  auto done = runWorker({subcommand, in.string(), out.string()},
                        {.timeout = timeout, .memoryLimit = workerMemoryLimit()}, run);
  if (!done) return ofScratch(done.error());
  auto bytes = readFile(out);
  auto answer = bytes ? decodeTetAnswer(*bytes) : Result<TetAnswer>(passOn(bytes));
  // It claims to be done and is not: as good as a crash
  if (!answer) {
    return fail(ErrorCode::WorkerCrashed,
                "ecorche-worker left no sound answer: " + answer.error().message);
  }
  return answer;
}

Result<TetAnswer> askTetgen(const TaggedSurface& walls, const FillTask& task, RunContext& run) {
  const Stage stage(run, "domain: tets");
  const TetRequest request{walls, task.points, pointsInVoids(walls), kTetgenSwitches};
  return askWorker("tetrahedralize", encodeTetRequest(request), task.workerTimeout, run);
}

Result<TetAnswer> askMesh3(const FillTask& task, RunContext& run) {
  const Stage stage(run, "domain: Mesh_3");
  const FillRequest request{task.carved, task.cutPlanes, task.sizing, task.scale,
                            0.5 * task.tolerance};
  return askWorker("fill", encodeFillRequest(request), task.workerTimeout, run);
}

/// Another mesher may do better; against a full disk or a cancel it would not.
bool anotherMayHelp(const Result<TetAnswer>& answer) {
  if (answer) return false;
  switch (answer.error().code) {
    case ErrorCode::MeshingFailed:
    case ErrorCode::WorkerCrashed:
    case ErrorCode::WorkerTimedOut:
      return true;
    default:
      return false;
  }
}

std::string described(std::int32_t tag, const FillTask& task) {
  const BoundaryTag of = unpacked(tag);
  const auto index = static_cast<std::size_t>(of.index);
  switch (of.kind) {
    case BoundaryTag::Kind::Skin:
      return "the skin";
    case BoundaryTag::Kind::Bone:
      return index < task.boneNames.size() ? fmt::format("\"{}\"", task.boneNames[index])
                                           : "a bone";
    case BoundaryTag::Kind::CutPlane:
      return "a cut plane";
    case BoundaryTag::Kind::Obstacle:
      return "an obstacle";
    case BoundaryTag::Kind::Cavity:
      return "a cavity";
  }
  return "a wall";
}

Error bothRefused(const FillTask& task, const Error& tetgen, const Error& mesh3) {
  const bool tooSlow = tetgen.code == ErrorCode::WorkerTimedOut && mesh3.code == tetgen.code;
  Error error{
      tooSlow ? ErrorCode::WorkerTimedOut : ErrorCode::MeshingFailed, {}, {.object = "domain"}};
  std::string where;
  std::string wayOut =
      "Another number of tets (--tets) or a larger surfaceTolerance may do; `ecorche check` shows "
      "what is wrong with the meshes";
  if (tooSlow) {
    error.message = fmt::format(
        "the room between skin and bones was not filled with tets in time: TetGen: {}; CGAL "
        "Mesh_3: {}. Fewer tets (--tets) take less, --mesher-timeout allows more",
        tetgen.message, mesh3.message);
    return error;
  }
  const auto crossings = mesh::selfIntersections(task.carved.V, task.carved.F);
  if (!crossings.empty()) {
    const auto [f, g] = crossings.front();
    const Vector3 at =
        (task.carved.V.row(task.carved.F(f, 0)) + task.carved.V.row(task.carved.F(f, 1)) +
         task.carved.V.row(task.carved.F(f, 2)))
            .transpose() /
        3.0;
    error.place.point = at;
    where = fmt::format("; {} and {} cross, or nearly so, at ({:.4g}, {:.4g}, {:.4g}) m",
                        described(task.carved.tag[static_cast<std::size_t>(f)], task),
                        described(task.carved.tag[static_cast<std::size_t>(g)], task), at.x(),
                        at.y(), at.z());
    const auto isSkin = [&](std::int32_t face) {
      return unpacked(task.carved.tag[static_cast<std::size_t>(face)]).kind ==
             BoundaryTag::Kind::Skin;
    };
    if (isSkin(f) && isSkin(g)) {
      error.place.object = "skin";
      wayOut =
          "Ask for \"repair\": \"wrap\" at the skin (a skin laid around it), or mend it "
          "there where it was made";
    }
  }
  error.message = fmt::format(
      "the room between skin and bones cannot be filled with tets: TetGen: {}; CGAL Mesh_3: {}{}. "
      "{}",
      tetgen.message, mesh3.message, where, wayOut);
  return error;
}

tl::unexpected<Error> outOfReach(Error error) {
  if (error.code == ErrorCode::OutOfMemory) error.message += "; fewer tets (--tets) take less";
  return tl::unexpected(std::move(error));
}

}  // namespace

Result<Fill> fillWithTets(const FillTask& task, RunContext& run) {
  Fill out;
  out.mesher = "TetGen";
  auto answer = askTetgen(task.walls, task, run);
  // What took too long once takes longer with more triangles
  if (anotherMayHelp(answer) && answer.error().code != ErrorCode::WorkerTimedOut) {
    const std::string reason = answer.error().message;
    answer = askTetgen(task.carved, task, run);
    out.ofWalls = false;
    if (answer) {
      out.findings.push_back(
          {.severity = Severity::Warning,
           .kind = "mesher-refused",
           .object = "domain",
           .message = fmt::format(
               "TetGen refused the resampled walls ({}); it was given walls at their full density",
               reason)});
    }
  }
  if (anotherMayHelp(answer)) {
    const Error refusal = answer.error();
    out.fallback = true;
    out.fallbackReason = refusal.message;
    out.mesher = "CGAL Mesh_3";
    out.ofWalls = false;
    answer = askMesh3(task, run);
    if (anotherMayHelp(answer)) {
      return tl::unexpected(bothRefused(task, refusal, answer.error()));
    }
    if (!answer) return outOfReach(answer.error());
    out.findings.push_back(
        {.severity = Severity::Warning,
         .kind = "fallback",
         .object = "domain",
         .message = fmt::format(
             "TetGen refused the domain ({}); it was filled by CGAL Mesh_3, which makes the "
             "surface anew and rounds its edges",
             out.fallbackReason)});
  }
  if (!answer) return outOfReach(answer.error());
  out.tets = std::move(*answer);
  return out;
}

}  // namespace ecorche::domain
