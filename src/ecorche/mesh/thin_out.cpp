#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/GarlandHeckbert_plane_policies.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>
#include <ecorche/mesh/cgal_surface.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/thin_out.h>

#include <cmath>

namespace ecorche::mesh {

namespace {

namespace SMS = CGAL::Surface_mesh_simplification;

/// Ends where the next collapse would lead too far from the planes it answers for, or on a cancel.
struct FarEnough {
  double limit;  // of summed squared distances [m²]
  const RunContext* run;
  template <class Cost, class Profile, class Size>
  bool operator()(const Cost& cost, const Profile&, Size, Size) const {
    return cost > limit || run->cancelled();
  }
};

}  // namespace

Result<std::optional<ThinnedSurface>> thinOut(const SurfaceMesh& mesh, double allowed,
                                              RunContext& run) {
  const Stage stage(run, "thinning out");
  auto surface = toCgal(mesh);
  if (!surface) return std::optional<ThinnedSurface>();
  using Policies = SMS::GarlandHeckbert_plane_policies<CgalSurface, CgalKernel>;
  const Policies policies(*surface);
  try {
    SMS::edge_collapse(
        *surface, FarEnough{allowed * allowed, &run},
        CGAL::parameters::get_cost(policies.get_cost()).get_placement(policies.get_placement()));
  } catch (const std::exception&) {
    return std::optional<ThinnedSurface>();  // a precondition that geometry this bad breaks
  }
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "thinning out", {.object = mesh.name});

  ThinnedSurface out{fromCgal(*surface, mesh.name), 0.0};
  if (out.mesh.F.rows() > mesh.F.rows() / 2 || !checkSurface(out.mesh).isSound())
    return std::optional<ThinnedSurface>();
  // Old triangles are small, so that their corners speak for them; new ones are not
  const double meanEdge =
      std::sqrt(2.3 * surfaceArea(mesh.V, mesh.F) / static_cast<double>(mesh.F.rows()));
  const auto apart = surfaceDeviation(out.mesh, mesh, 4.0 * meanEdge, run);
  if (!apart) return passOn(apart);
  out.deviation = apart->max();
  if (out.deviation > allowed) return std::optional<ThinnedSurface>();
  return std::optional<ThinnedSurface>(std::move(out));
}

}  // namespace ecorche::mesh
