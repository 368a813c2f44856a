#include <ecorche/exchange/check_parts.h>
#include <ecorche/exchange/surface_faults.h>
#include <ecorche/fiber/curve_tets.h>
#include <ecorche/mesh/read_mesh.h>
#include <ecorche/mesh/surface_mesh.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace ecorche::exchange {

namespace {

// Counts faults over all muscles and remembers the worst and the first place.
struct Tally {
  Check check;
  std::int64_t muscles = 0;

  void add(double value, const std::string& muscle, std::optional<Eigen::Vector3d> at) {
    if (value <= 0.0) return;
    check.value += value;
    if (muscles++ == 0) {
      check.object = muscle;
      check.point = at;
    }
  }
  void finish(Checks& checks, const char* what) {
    check.pass = check.value == 0.0;
    check.detail = check.pass ? fmt::format("no {}", what)
                              : fmt::format("{} {} on {} muscles, first on \"{}\"", check.value,
                                            what, muscles, check.object);
    checks.push_back(std::move(check));
  }
};

// Faces between one tissue's tets and anything else, facing outward.
mesh::Triangles surfaceOf(const CheckedFiles& files, std::int32_t id) {
  const AnatomyFile& a = *files.anatomy;
  std::vector<std::array<std::int32_t, 3>> faces;
  for (const std::int32_t t : files.tetsOf[static_cast<std::size_t>(id)]) {
    for (int k = 0; k < 4; ++k) {
      const std::int32_t n = files.adjacency.neighbours(t, k);
      if (n >= 0 && a.tissue[static_cast<std::size_t>(n)] == id) continue;
      faces.push_back({a.mesh.T(t, mesh::kTetFace[k][0]), a.mesh.T(t, mesh::kTetFace[k][1]),
                       a.mesh.T(t, mesh::kTetFace[k][2])});
    }
  }
  mesh::Triangles F(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (std::size_t c = 0; c < 3; ++c)
      F(static_cast<Eigen::Index>(f), static_cast<Eigen::Index>(c)) = faces[f][c];
  }
  return F;
}

std::int64_t componentCount(const CheckedFiles& files, std::int32_t id,
                            std::vector<std::uint8_t>& seen) {
  std::int64_t count = 0;
  std::vector<std::int32_t> open;
  for (const std::int32_t seed : files.tetsOf[static_cast<std::size_t>(id)]) {
    if (seen[static_cast<std::size_t>(seed)]) continue;
    ++count;
    seen[static_cast<std::size_t>(seed)] = 1;
    open.push_back(seed);
    while (!open.empty()) {
      const std::int32_t t = open.back();
      open.pop_back();
      for (int k = 0; k < 4; ++k) {
        const std::int32_t n = files.adjacency.neighbours(t, k);
        if (n < 0 || seen[static_cast<std::size_t>(n)] ||
            files.anatomy->tissue[static_cast<std::size_t>(n)] != id)
          continue;
        seen[static_cast<std::size_t>(n)] = 1;
        open.push_back(n);
      }
    }
  }
  return count;
}

// Share of the tissue's curves that runs through its own tets.
double shareInside(const CheckedFiles& files, const TissueRecord& tissue) {
  std::vector<std::vector<mesh::Vector3>> lines;
  for (const CurveRecord& curve : tissue.curves) lines.push_back(curve.points);
  const auto id = static_cast<std::size_t>(tissue.id);
  return fiber::shareInside(
      files.anatomy->mesh,
      id < files.tetsOf.size() ? files.tetsOf[id] : std::vector<std::int32_t>{}, lines);
}

// A surface in the order of its points, for comparing two whatever the order of faces and vertices.
using FacePoints = std::array<std::array<double, 3>, 3>;

std::vector<FacePoints> sortedFaces(const mesh::Positions& V, const mesh::Triangles& F) {
  std::vector<FacePoints> out(static_cast<std::size_t>(F.rows()));
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    FacePoints& face = out[static_cast<std::size_t>(f)];
    for (std::size_t c = 0; c < 3; ++c) {
      const auto v = V.row(F(f, static_cast<Eigen::Index>(c)));
      // Signed zeros are equal points
      face[c] = {v[0] + 0.0, v[1] + 0.0, v[2] + 0.0};
    }
    // Rotate the smallest corner to the front: orientation stays
    std::ranges::rotate(face, std::ranges::min_element(face));
  }
  std::ranges::sort(out);
  return out;
}

// Largest relative difference of volume, or infinity where faces differ.
double surfaceDifference(const CheckedFiles& files, std::int32_t id, const mesh::Triangles& F,
                         const mesh::SurfaceMesh& written) {
  if (sortedFaces(files.anatomy->mesh.V, F) != sortedFaces(written.V, written.F)) return INFINITY;
  double volume = 0.0;
  for (const std::int32_t t : files.tetsOf[static_cast<std::size_t>(id)]) volume += files.volume[t];
  return std::abs(mesh::signedVolume(written.V, written.F) - volume) / volume;
}

}  // namespace

Result<void> checkMuscles(const CheckedFiles& files, CheckReport& report, RunContext& run) {
  Tally open{{"muscles-closed"}};
  Tally edges{{"muscles-manifold-edges"}};
  Tally vertices{{"muscles-manifold-vertices"}};
  Tally pieces{{"muscles-connected"}};
  Check inside{"curves-inside"};
  inside.value = 1.0;
  inside.limit = 0.95;
  Check agree{"surfaces-agree"};
  agree.limit = 1e-9;
  std::int64_t compared = 0;
  std::int64_t empty = 0;

  std::vector<std::uint8_t> seen(files.anatomy->tissue.size(), 0);
  for (const TissueRecord& tissue : files.record.tissues) {
    TissueFigures figures;
    figures.id = tissue.id;
    figures.name = tissue.name;
    figures.kind = tissue.kind;
    figures.file = tissue.file;
    const bool muscle = tissue.kind == "muscle";
    const bool hasTets = static_cast<std::size_t>(tissue.id) < files.tetsOf.size() &&
                         !files.tetsOf[static_cast<std::size_t>(tissue.id)].empty();
    if (muscle) {
      const double share = shareInside(files, tissue);
      if (share < inside.value) {
        inside.value = share;
        inside.object = tissue.name;
      }
    }
    if (!hasTets) {
      if (muscle && empty++ == 0) pieces.check.object = tissue.name;
      report.tissues.push_back(std::move(figures));
      continue;
    }

    const mesh::Triangles F = surfaceOf(files, tissue.id);
    figures.tets = std::ssize(files.tetsOf[static_cast<std::size_t>(tissue.id)]);
    for (const std::int32_t t : files.tetsOf[static_cast<std::size_t>(tissue.id)])
      figures.volumeCm3 += 1e6 * files.volume[t];
    figures.areaCm2 = 1e4 * mesh::surfaceArea(files.anatomy->mesh.V, F);
    figures.components = componentCount(files, tissue.id, seen);
    if (muscle) {
      const SurfaceFaults faults = surfaceFaults(F);
      const auto at = [&](std::int32_t v) -> std::optional<Eigen::Vector3d> {
        if (v < 0) return std::nullopt;
        return files.anatomy->mesh.V.row(v).transpose();
      };
      open.add(static_cast<double>(faults.openEdges), tissue.name, at(faults.openAt));
      edges.add(static_cast<double>(faults.nonManifoldEdges), tissue.name,
                at(faults.nonManifoldEdgeAt));
      vertices.add(static_cast<double>(faults.nonManifoldVertices), tissue.name,
                   at(faults.nonManifoldVertexAt));
      // Heads may be pieces of their own
      const auto allowed = std::max<std::int64_t>(1, std::ssize(tissue.curves));
      pieces.add(static_cast<double>(std::max<std::int64_t>(0, figures.components - allowed)),
                 tissue.name, std::nullopt);
    }

    if (!tissue.file.empty()) {
      auto written = mesh::readMesh(files.folder / tissue.file, {}, run);
      if (!written) return passOn(written);
      const double difference = surfaceDifference(files, tissue.id, F, *written);
      ++compared;
      if (!(difference <= agree.value)) {
        agree.value = difference;
        agree.object = tissue.file;
      }
    }
    report.tissues.push_back(std::move(figures));
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "checking");
  }

  open.finish(report.checks, "open edges");
  edges.finish(report.checks, "non-manifold edges");
  vertices.finish(report.checks, "non-manifold vertices");
  if (empty > 0) {
    pieces.check.value += static_cast<double>(empty);
    pieces.muscles += empty;
  }
  pieces.finish(report.checks, "superfluous pieces or muscles without tets");
  inside.pass = inside.value >= inside.limit;
  inside.detail = inside.object.empty()
                      ? "all curves lie in their own muscle"
                      : fmt::format("{:.1f} % of \"{}\" lies in its own muscle, the least of all",
                                    100.0 * inside.value, inside.object);
  report.checks.push_back(std::move(inside));
  if (compared > 0) {
    agree.pass = agree.value <= agree.limit;
    agree.detail = std::isinf(agree.value)
                       ? fmt::format("{} has other faces than its tets", agree.object)
                       : fmt::format("{} surfaces have exactly the faces of their tets", compared);
    report.checks.push_back(std::move(agree));
  }
  return {};
}

}  // namespace ecorche::exchange
