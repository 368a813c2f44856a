#include <CGAL/alpha_wrap_3.h>
#include <ecorche/mesh/cgal_surface.h>
#include <ecorche/mesh/surface_wrap.h>
#include <fmt/format.h>

#include <array>
#include <vector>

namespace ecorche::mesh {

namespace {

struct Stopped {};

/// Looks for a cancel before every point that the wrap takes; CGAL has no other way to be stopped.
struct Stoppable : CGAL::Alpha_wraps_3::internal::Wrapping_default_visitor {
  const RunContext* run = nullptr;
  template <class Wrapper, class Point>
  void before_Steiner_point_insertion(const Wrapper&, const Point&) {
    if (run->cancelled()) throw Stopped();
  }
};

}  // namespace

Result<SurfaceMesh> wrapSurface(const SurfaceMesh& mesh, double alpha, double offset,
                                RunContext& run) {
  using Point = CgalKernel::Point_3;
  std::vector<Point> points;
  std::vector<std::array<std::size_t, 3>> faces;
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v)
    points.emplace_back(mesh.V(v, 0), mesh.V(v, 1), mesh.V(v, 2));
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    std::array<std::size_t, 3> face{};
    for (int k = 0; k < 3; ++k)
      face[static_cast<std::size_t>(k)] = static_cast<std::size_t>(mesh.F(f, k));
    if (!CGAL::collinear(points[face[0]], points[face[1]], points[face[2]])) faces.push_back(face);
  }
  if (faces.empty()) {
    return fail(ErrorCode::MeshWithoutFaces,
                fmt::format("\"{}\" has no triangle with an area to wrap", mesh.name),
                {.object = mesh.name});
  }
  CgalSurface wrapped;
  Stoppable visitor;
  visitor.run = &run;
  try {
    CGAL::alpha_wrap_3(points, faces, alpha, offset, wrapped, CGAL::parameters::default_values(),
                       CGAL::parameters::visitor(visitor));
  } catch (const Stopped&) {
    return fail(ErrorCode::Cancelled, "wrapping was interrupted", {.object = mesh.name});
  }
  return fromCgal(wrapped, mesh.name);
}

}  // namespace ecorche::mesh
