#include <ecorche/authoring/offset_skin.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/surface_wrap.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace ecorche::authoring {

namespace {

constexpr Eigen::Index kMostFaces = 40000;  // that are still made finer

/// Every face cut into four.
mesh::SurfaceMesh finer(const mesh::SurfaceMesh& m) {
  mesh::SurfaceMesh out = m;
  const mesh::SurfaceEdges edges = mesh::surfaceEdges(m.F);
  const Eigen::Index first = m.V.rows();
  out.V.conservativeResize(first + std::ssize(edges.ends), 3);
  std::vector<std::int32_t> half(
      static_cast<std::size_t>(3 * m.F.rows()));  // vertex, by 3·face + side
  for (std::size_t e = 0; e < edges.count(); ++e) {
    const auto v = static_cast<std::int32_t>(first + static_cast<Eigen::Index>(e));
    out.V.row(v) = 0.5 * (m.V.row(edges.ends[e][0]) + m.V.row(edges.ends[e][1]));
    for (std::int32_t u = edges.first[e]; u < edges.first[e + 1]; ++u)
      half[static_cast<std::size_t>(edges.slot[static_cast<std::size_t>(u)])] = v;
  }
  out.F.resize(4 * m.F.rows(), 3);
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
    const auto h = [&](int k) { return half[static_cast<std::size_t>(3 * f + k)]; };
    for (int k = 0; k < 3; ++k) out.F.row(4 * f + k) << m.F(f, k), h(k), h((k + 2) % 3);
    out.F.row(4 * f + 3) << h(0), h(1), h(2);
  }
  return out;
}

double meanEdge(const mesh::SurfaceMesh& m) {
  return std::sqrt(2.3 * mesh::surfaceArea(m.V, m.F) / static_cast<double>(m.F.rows()));
}

/// Facets of a wrap are as rough as its gaps are wide: each vertex goes towards the middle of its
/// neighbours, but no nearer to the bones than the distance.
mesh::SurfaceMesh smoothed(mesh::SurfaceMesh skin, const mesh::SurfaceQuery& bones,
                           double distance) {
  constexpr int kRounds = 20;
  const mesh::SurfaceEdges edges = mesh::surfaceEdges(skin.F);
  for (int round = 0; round < kRounds; ++round) {
    mesh::Positions sum = mesh::Positions::Zero(skin.V.rows(), 3);
    Eigen::VectorXd count = Eigen::VectorXd::Zero(skin.V.rows());
    for (const auto& [a, b] : edges.ends) {
      sum.row(a) += skin.V.row(b);
      sum.row(b) += skin.V.row(a);
      ++count[a];
      ++count[b];
    }
    parallelFor(skin.V.rows(), [&](std::int64_t v) {
      mesh::Vector3 p = 0.5 * (skin.V.row(v) + sum.row(v) / count[v]).transpose();
      const auto nearest = bones.closest(p);
      if (nearest.distance < distance && nearest.distance > 0.0)
        p = nearest.point + distance / nearest.distance * (p - nearest.point);
      sum.row(v) = p.transpose();
    });
    skin.V = sum;
  }
  return skin;
}

}  // namespace

Result<mesh::SurfaceMesh> offsetSkin(const std::vector<mesh::SurfaceMesh>& bones, double distance,
                                     RunContext& run) {
  const Stage stage(run, "skin around bones");
  for (const mesh::SurfaceMesh& bone : bones) {
    if (bone.V.allFinite()) continue;
    return fail(ErrorCode::NonFiniteVertex,
                fmt::format("\"{}\" has a vertex that is no number, so no skin can be laid around "
                            "it; export it again from where it was made",
                            bone.name),
                {.object = bone.name});
  }
  const mesh::SurfaceMesh all = mesh::joined(bones, "skin");
  const double diagonal = mesh::boundingBox(all).diagonal();
  // Wide enough to lie smoothly over single bones; wider where bones stand so far apart that each
  // got a skin of its own. In the end the wrap is the convex hull's, and that is one piece.
  for (double gap = std::max(2.0 * distance, 0.04 * diagonal);; gap *= 2.0) {
    auto skin = mesh::wrapSurface(all, gap, distance, run);
    if (!skin) return skin;
    if (mesh::components(skin->F).count > 1 && gap < 2.0 * diagonal) continue;
    mesh::SurfaceMesh fine = finer(*skin);
    // Long edges would cut through the distance
    while (meanEdge(fine) > 0.5 * distance && fine.F.rows() < kMostFaces) fine = finer(fine);
    mesh::SurfaceMesh smooth = smoothed(std::move(fine), mesh::SurfaceQuery(all), distance);
    return mesh::isUncrossed(smooth) ? std::move(smooth) : std::move(*skin);
  }
}

}  // namespace ecorche::authoring
