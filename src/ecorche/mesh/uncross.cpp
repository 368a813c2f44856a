#include <CGAL/Polygon_mesh_processing/repair_self_intersections.h>
#include <ecorche/mesh/cgal_surface.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/uncross.h>

namespace ecorche::mesh {

std::optional<SurfaceMesh> uncross(const SurfaceMesh& mesh) {
  auto surface = toCgal(mesh);
  if (!surface) return std::nullopt;
  try {
    if (!CGAL::Polygon_mesh_processing::experimental::remove_self_intersections(*surface))
      return std::nullopt;
  } catch (const std::exception&) {
    // A precondition that geometry this bad breaks; what it leaves is no mesh any more
    return std::nullopt;
  }
  SurfaceMesh out = fromCgal(*surface, mesh.name);
  if (!isUncrossed(out)) return std::nullopt;
  return out;
}

}  // namespace ecorche::mesh
