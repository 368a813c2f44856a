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

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <map>
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

/// How often the surface winds around what lies just above a face: half-way to what is met next.
std::optional<int> windingAbove(const SurfaceQuery& query, const SurfaceMesh& mesh, Eigen::Index f,
                                double hair) {
  const Vector3 a = mesh.V.row(mesh.F(f, 0)).transpose();
  const Vector3 b = mesh.V.row(mesh.F(f, 1)).transpose();
  const Vector3 c = mesh.V.row(mesh.F(f, 2)).transpose();
  const Vector3 normal = (b - a).cross(c - a).normalized();
  const Vector3 middle = (a + b + c) / 3.0;
  for (const SurfaceQuery::Hit& hit : query.allHits(middle, normal)) {
    if (hit.t > hair) return query.windingNumber(middle + 0.5 * hit.t * normal);
  }
  return 0;
}

/// Where a fold ends in a vertex, two tips touch in it: each gets a vertex of its own.
void splitTips(SurfaceMesh& mesh) {
  const VertexFans fans = vertexFans(mesh.F, surfaceEdges(mesh.F));
  for (const std::int32_t tip : fans.nonManifoldVertices) {
    std::map<std::int32_t, std::int32_t> copyOfFan;
    for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
      for (int k = 0; k < 3; ++k) {
        if (mesh.F(f, k) != tip) continue;
        const auto [copy, fresh] =
            copyOfFan.try_emplace(fans.fanOfCorner[static_cast<std::size_t>(3 * f + k)],
                                  static_cast<std::int32_t>(mesh.V.rows()));
        if (fresh) {
          mesh.V.conservativeResize(mesh.V.rows() + 1, 3);
          mesh.V.row(copy->second) = mesh.V.row(tip);
        }
        mesh.F(f, k) = copy->second;
      }
    }
  }
}

}  // namespace

std::optional<SurfaceMesh> outerHull(const SurfaceMesh& mesh) {
  auto surface = toCgal(mesh);
  if (!surface || liesUponItself(mesh)) return std::nullopt;
  try {
    CGAL::Polygon_mesh_processing::experimental::autorefine(*surface);
  } catch (const std::exception&) {
    return std::nullopt;  // faces upon one another
  }
  SurfaceMesh refined = weldExact(fromCgal(*surface, mesh.name));

  const FaceComponents patches = patchesOf(refined.F);
  const auto patchOf = [&](Eigen::Index f) {
    return static_cast<std::size_t>(patches.label[static_cast<std::size_t>(f)]);
  };
  // The largest face speaks for its patch
  std::vector<double> largest(static_cast<std::size_t>(patches.count), -1.0);
  std::vector<Eigen::Index> speaker(largest.size(), 0);
  for (Eigen::Index f = 0; f < refined.F.rows(); ++f) {
    const Vector3 a = refined.V.row(refined.F(f, 0)).transpose();
    const Vector3 b = refined.V.row(refined.F(f, 1)).transpose();
    const Vector3 c = refined.V.row(refined.F(f, 2)).transpose();
    const double area = (b - a).cross(c - a).norm();
    const std::size_t p = patchOf(f);
    if (area > largest[p]) {
      largest[p] = area;
      speaker[p] = f;
    }
  }
  const SurfaceQuery query(mesh);
  const double hair = 1e-9 * boundingBox(mesh).diagonal();
  std::vector<char> kept(largest.size(), 0);
  for (std::size_t p = 0; p < kept.size(); ++p) {
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
