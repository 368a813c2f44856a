#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <ecorche/mesh/cgal_surface.h>
#include <ecorche/mesh/orientation.h>
#include <ecorche/mesh/outer_hull.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/tips.h>
#include <ecorche/mesh/weld.h>
#include <ecorche/mesh/winding_above.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <vector>

namespace ecorche::mesh {

namespace {

/// Pieces of surface between the lines where it cuts itself: there edges have four faces.
FaceComponents patchesOf(const Triangles& F) {
  const SurfaceEdges all = surfaceEdges(F);
  SurfaceEdges within;
  within.first.push_back(0);
  for (std::size_t e = 0; e < all.count(); ++e) {
    if (all.faceCount(e) != 2) continue;
    within.ends.push_back(all.ends[e]);
    const auto at = static_cast<std::size_t>(all.first[e]);
    within.slot.insert(within.slot.end(), {all.slot[at], all.slot[at + 1]});
    within.first.push_back(static_cast<std::int32_t>(within.slot.size()));
  }
  return components(F, within);
}

/// Faces that overlap within one plane: CGAL's refinement does not refuse them, it crashes.
bool liesUponItself(const SurfaceMesh& mesh) {
  const auto at = [&](std::int32_t f, int k) -> Vector3 {
    return mesh.V.row(mesh.F(f, k)).transpose();
  };
  return std::ranges::any_of(selfIntersections(mesh.V, mesh.F), [&](const auto& pair) {
    const auto [f, g] = pair;
    for (int k = 0; k < 3; ++k) {
      if (orientation(at(f, 0), at(f, 1), at(f, 2), at(g, k)) != 0) return false;
    }
    return true;
  });
}

/// Faces between crossings nearer than doubles can tell have a vertex twice once these are one, and
/// their neighbours meet without them.
void dropCollapsed(Triangles& F) {
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    if (F(f, 0) == F(f, 1) || F(f, 1) == F(f, 2) || F(f, 2) == F(f, 0)) continue;
    F.row(count++) = F.row(f).eval();
  }
  F.conservativeResize(count, 3);
}

/// Where a fold ends in a vertex, two tips touch in it: each gets a vertex of its own.
void splitTips(SurfaceMesh& mesh) {
  const VertexFans fans = vertexFans(mesh.F, surfaceEdges(mesh.F));
  const auto& tips = fans.nonManifoldVertices;
  std::vector<std::int32_t> copyOfFan(static_cast<std::size_t>(fans.count), -1);
  std::vector<std::int32_t> original;
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t tip = mesh.F(f, k);
      if (!std::ranges::binary_search(tips, tip)) continue;
      std::int32_t& copy = copyOfFan[static_cast<std::size_t>(
          fans.fanOfCorner[static_cast<std::size_t>(3 * f + k)])];
      if (copy < 0) {
        copy = static_cast<std::int32_t>(mesh.V.rows() + std::ssize(original));
        original.push_back(tip);
      }
      mesh.F(f, k) = copy;
    }
  }
  const Positions copies = mesh.V(original, Eigen::all);
  mesh.V.conservativeResize(mesh.V.rows() + copies.rows(), 3);
  mesh.V.bottomRows(copies.rows()) = copies;
}

}  // namespace

std::optional<SurfaceMesh> outerHull(const SurfaceMesh& mesh, RunContext& run) {
  auto surface = toCgal(mesh);
  if (!surface || liesUponItself(mesh)) return std::nullopt;
  try {
    CGAL::Polygon_mesh_processing::experimental::autorefine(*surface);
  } catch (const std::exception&) {
    return std::nullopt;  // faces upon one another
  }
  SurfaceMesh refined = weldExact(fromCgal(*surface, mesh.name));
  dropCollapsed(refined.F);

  const FaceComponents patches = patchesOf(refined.F);
  const auto patchOf = [&](Eigen::Index f) {
    return static_cast<std::size_t>(patches.label[static_cast<std::size_t>(f)]);
  };
  const std::vector<Eigen::Index> speaker = largestFaces(refined, patches);
  const SurfaceQuery query(mesh);
  const double hair = 1e-9 * boundingBox(mesh).diagonal();
  std::vector<char> kept(speaker.size(), 0);
  for (std::size_t p = 0; p < kept.size(); ++p) {
    if (run.cancelled()) return std::nullopt;
    const auto winding = windingAbove(query, refined, speaker[p], hair);
    if (!winding) return std::nullopt;
    // Below its face the surface winds once more than above
    kept[p] = *winding == 0;
  }
  SurfaceMesh out = refined;
  Eigen::Index count = 0;
  for (Eigen::Index f = 0; f < refined.F.rows(); ++f) {
    if (kept[patchOf(f)] != 0) out.F.row(count++) = refined.F.row(f);
  }
  out.F.conservativeResize(count, 3);
  splitTips(out);
  out = compacted(out);
  drawTipsApart(out.V, out.F);
  if (count == 0 || !isUncrossed(out)) return std::nullopt;
  return out;
}

}  // namespace ecorche::mesh
