#include <ecorche/core/parallel.h>
#include <ecorche/domain/finish_domain.h>
#include <ecorche/domain/tet_smoothing.h>
#include <ecorche/domain/triangle_tree.h>
#include <ecorche/domain/vertex_links.h>
#include <ecorche/mesh/orientation.h>
#include <ecorche/mesh/surface_topology.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace ecorche::domain {

using mesh::Vector3;

namespace {

constexpr double kPoorDeg = 5.0;
constexpr double kSmoothBelowDeg = 10.0;
constexpr double kSpeckShare = 1e-3;  // components with less of the volume are dropped

using FaceKey = std::array<std::int32_t, 3>;

FaceKey keyOf(const mesh::Triangles& F, Eigen::Index f) {
  FaceKey key{F(f, 0), F(f, 1), F(f, 2)};
  std::ranges::sort(key);
  return key;
}

mesh::TetMesh keepTets(const mesh::TetMesh& mesh, const std::vector<std::uint8_t>& keep,
                       std::vector<std::int32_t>& vertexOf) {
  std::vector<std::int32_t> fresh(static_cast<std::size_t>(mesh.V.rows()), -1);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    if (keep[static_cast<std::size_t>(t)] == 0) continue;
    rows.push_back(t);
    for (int k = 0; k < 4; ++k) fresh[static_cast<std::size_t>(mesh.T(t, k))] = 0;
  }
  std::int32_t count = 0;
  for (auto& v : fresh) {
    if (v == 0) v = count++;
  }
  mesh::TetMesh out;
  out.V.resize(count, 3);
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    if (fresh[static_cast<std::size_t>(v)] >= 0)
      out.V.row(fresh[static_cast<std::size_t>(v)]) = mesh.V.row(v);
  }
  out.T.resize(static_cast<Eigen::Index>(rows.size()), 4);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (int k = 0; k < 4; ++k) {
      out.T(static_cast<Eigen::Index>(r), k) = fresh[static_cast<std::size_t>(mesh.T(rows[r], k))];
    }
  }
  vertexOf = std::move(fresh);
  return out;
}

std::vector<std::int32_t> componentOfTet(const mesh::TetNeighbours& neighbours,
                                         std::int32_t& count) {
  std::vector<std::int32_t> label(static_cast<std::size_t>(neighbours.rows()), -1);
  count = 0;
  std::vector<std::int32_t> stack;
  for (std::int32_t t = 0; t < neighbours.rows(); ++t) {
    if (label[static_cast<std::size_t>(t)] >= 0) continue;
    stack.assign(1, t);
    label[static_cast<std::size_t>(t)] = count;
    while (!stack.empty()) {
      const std::int32_t a = stack.back();
      stack.pop_back();
      for (int k = 0; k < 4; ++k) {
        const std::int32_t n = neighbours(a, k);
        if (n < 0 || label[static_cast<std::size_t>(n)] >= 0) continue;
        label[static_cast<std::size_t>(n)] = count;
        stack.push_back(n);
      }
    }
    ++count;
  }
  return label;
}

}  // namespace

Result<Domain> finishDomain(TetAnswer answer, const TaggedSurface& walls, Domain out,
                            DomainReport& report, RunContext& run) {
  const Stage stage(run, "domain: verify");
  const auto broken = [&](std::string what) {
    return fail(ErrorCode::MeshingFailed, fmt::format("the mesher's answer is no domain: {}", what),
                {.object = "skin"});
  };
  mesh::TetMesh mesh{std::move(answer.V), std::move(answer.T)};
  if (mesh.T.rows() == 0) return broken("it holds no tets");

  // 1. TetGen's own orientation is the other one; flat tets go
  std::vector<std::uint8_t> keep(static_cast<std::size_t>(mesh.T.rows()), 1);
  parallelFor(mesh.T.rows(), [&](std::int64_t t) {
    const int side = mesh::orientation(mesh, t);
    if (side < 0) std::swap(mesh.T(t, 2), mesh.T(t, 3));
    keep[static_cast<std::size_t>(t)] = side != 0;
  });
  const auto flat = std::count(keep.begin(), keep.end(), 0);

  // 2. Tags of the mesher's boundary faces; faces it did not name take the tag of the nearest wall
  std::map<FaceKey, std::int32_t> tagOf;
  for (Eigen::Index f = 0; f < answer.F.rows(); ++f) {
    if (answer.tag[static_cast<std::size_t>(f)] >= 0)
      tagOf[keyOf(answer.F, f)] = answer.tag[static_cast<std::size_t>(f)];
  }

  // 3. Components: specks go, with what was said about them
  mesh::TetAdjacency adjacency = mesh::tetAdjacency(mesh.T);
  if (adjacency.nonManifoldFaces > 0)
    return broken(fmt::format("{} faces belong to three tets", adjacency.nonManifoldFaces));
  std::int32_t componentCount = 0;
  const std::vector<std::int32_t> component = componentOfTet(adjacency.neighbours, componentCount);
  std::vector<double> volumeOf(static_cast<std::size_t>(componentCount), 0.0);
  std::vector<std::uint8_t> hasSkin(volumeOf.size(), 0);
  std::vector<Vector3> placeOf(volumeOf.size(), Vector3::Zero());
  double whole = 0.0;
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    const auto c = static_cast<std::size_t>(component[static_cast<std::size_t>(t)]);
    const double v = mesh::signedVolume(mesh, t);
    volumeOf[c] += v;
    whole += v;
    placeOf[c] = mesh.V.row(mesh.T(t, 0)).transpose();
    for (int k = 0; k < 4; ++k) {
      if (adjacency.neighbours(t, k) >= 0) continue;
      FaceKey key{mesh.T(t, mesh::kTetFace[k][0]), mesh.T(t, mesh::kTetFace[k][1]),
                  mesh.T(t, mesh::kTetFace[k][2])};
      std::ranges::sort(key);
      const auto tag = tagOf.find(key);
      if (tag != tagOf.end() && unpacked(tag->second).kind == BoundaryTag::Kind::Skin)
        hasSkin[c] = 1;
    }
  }
  double dropped = 0.0;
  report.components = 0;
  std::vector<std::uint8_t> keepComponent(volumeOf.size(), 1);
  for (std::size_t c = 0; c < volumeOf.size(); ++c) {
    if (volumeOf[c] >= kSpeckShare * whole) {
      ++report.components;
      if (hasSkin[c] == 0) {
        return fail(ErrorCode::ComponentWithoutSkin,
                    fmt::format("a part of {:.3g} cm³ between bones and cut planes touches no "
                                "skin; no fat could reach it. "
                                "Move the cut plane or close the gap between the bones",
                                volumeOf[c] * 1e6),
                    {.object = "skin", .point = placeOf[c]});
      }
      continue;
    }
    keepComponent[c] = 0;
    dropped += volumeOf[c];
    report.findings.push_back(
        {Severity::Repaired, "speck", "domain",
         fmt::format("a separate part of {:.3g} mm³ was left out", volumeOf[c] * 1e9), placeOf[c],
         volumeOf[c]});
  }
  for (std::size_t t = 0; t < keep.size(); ++t) {
    keep[t] = keep[t] != 0 && keepComponent[static_cast<std::size_t>(component[t])] != 0;
  }
  std::vector<std::int32_t> vertexOf;
  out.mesh = keepTets(mesh, keep, vertexOf);
  out.neighbours = mesh::tetAdjacency(out.mesh.T).neighbours;

  // 4. Boundary with tags
  const mesh::TetBoundary boundary = mesh::tetBoundary(out.mesh.T, out.neighbours);
  std::map<FaceKey, std::int32_t> tagOfKept;
  for (const auto& [key, tag] : tagOf) {
    FaceKey k{};
    for (std::size_t c = 0; c < 3; ++c) k[c] = vertexOf[static_cast<std::size_t>(key[c])];
    if (k[0] < 0 || k[1] < 0 || k[2] < 0) continue;
    std::ranges::sort(k);
    tagOfKept[k] = tag;
  }
  out.boundaryF = boundary.F;
  out.boundaryTet = boundary.tet;
  out.boundaryTag.resize(boundary.tet.size());
  std::optional<TriangleTree> tree;
  for (Eigen::Index b = 0; b < boundary.F.rows(); ++b) {
    const auto known = tagOfKept.find(keyOf(boundary.F, b));
    std::int32_t tag = known != tagOfKept.end() ? known->second : -1;
    if (tag < 0) {
      if (!tree) tree.emplace(walls.V, walls.F);
      const Vector3 centre = (out.mesh.V.row(boundary.F(b, 0)) + out.mesh.V.row(boundary.F(b, 1)) +
                              out.mesh.V.row(boundary.F(b, 2)))
                                 .transpose() /
                             3.0;
      tag = walls.tag[static_cast<std::size_t>(tree->closest(centre).triangle)];
    }
    out.boundaryTag[static_cast<std::size_t>(b)] = unpacked(tag);
  }
  out.onSkin.assign(static_cast<std::size_t>(out.mesh.V.rows()), 0);
  std::vector<std::uint8_t> fixed(out.onSkin.size(), 0);
  for (Eigen::Index b = 0; b < boundary.F.rows(); ++b) {
    for (int c = 0; c < 3; ++c) {
      const auto v = static_cast<std::size_t>(boundary.F(b, c));
      fixed[v] = 1;
      if (out.boundaryTag[static_cast<std::size_t>(b)].kind == BoundaryTag::Kind::Skin)
        out.onSkin[v] = 1;
    }
  }

  // 5. Slivers away from the walls are smoothed: the Laplacian has to stay sound
  const SmoothingResult smoothed = smoothSlivers(out.mesh, fixed, kSmoothBelowDeg, run);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped while verifying the domain");

  // 6. Proof
  const mesh::SurfaceEdges edges = mesh::surfaceEdges(out.boundaryF);
  if (!mesh::isClosed(out.boundaryF) || !mesh::isManifold(out.boundaryF)) {
    const auto fans = mesh::vertexFans(out.boundaryF, edges);
    return broken(fmt::format("its boundary is no closed manifold ({} vertices at fault)",
                              fans.nonManifoldVertices.size()));
  }
  if (const auto singular = firstSingularVertex(out.mesh, out.neighbours)) {
    const mesh::Vector3 p = out.mesh.V.row(*singular).transpose();
    return broken(fmt::format("it touches itself in a point at ({:.4g}, {:.4g}, {:.4g}) m", p.x(),
                              p.y(), p.z()));
  }
  out.volume = mesh::signedVolumes(out.mesh).sum();
  const double wallVolume = mesh::signedVolume(walls.V, walls.F);
  // TetGen keeps the walls as they are; Mesh_3 makes its own
  const double slack = report.fallback ? 1e-2 : 1e-9;
  if (std::abs(out.volume + dropped - wallVolume) > slack * wallVolume) {
    return broken(fmt::format("it encloses {:.6g} cm³ and its walls {:.6g} cm³", out.volume * 1e6,
                              wallVolume * 1e6));
  }
  const Eigen::MatrixX2d range = mesh::dihedralRangeDeg(out.mesh);
  report.minDihedralDeg = range.col(0).minCoeff();
  report.maxDihedralDeg = range.col(1).maxCoeff();
  report.poorTets = (range.col(0).array() < kPoorDeg).count();
  report.tets = out.mesh.T.rows();
  report.vertices = out.mesh.V.rows();
  report.freeVertices = out.freeVertexCount();
  report.boundaryFaces = out.boundaryF.rows();
  report.volume = out.volume;
  if (flat > 0) {
    report.findings.push_back({Severity::Repaired,
                               "flat-tets",
                               "domain",
                               fmt::format("{} tets without volume were dropped", flat),
                               {},
                               static_cast<double>(flat)});
  }
  if (smoothed.moved > 0) {
    report.findings.push_back(
        {Severity::Note,
         "slivers",
         "domain",
         fmt::format("{} tets had an angle below {}°; {} after moving {} inner vertices",
                     smoothed.before, kSmoothBelowDeg, smoothed.after, smoothed.moved),
         {},
         static_cast<double>(smoothed.after)});
  }
  return out;
}

}  // namespace ecorche::domain
