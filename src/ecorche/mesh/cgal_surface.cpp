#include <ecorche/mesh/cgal_surface.h>

namespace ecorche::mesh {

std::optional<CgalSurface> toCgal(const SurfaceMesh& mesh) {
  CgalSurface out;
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v)
    out.add_vertex(CgalKernel::Point_3(mesh.V(v, 0), mesh.V(v, 1), mesh.V(v, 2)));
  const auto vertex = [](std::int32_t v) {
    return CgalSurface::Vertex_index(static_cast<CgalSurface::size_type>(v));
  };
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    if (out.add_face(vertex(mesh.F(f, 0)), vertex(mesh.F(f, 1)), vertex(mesh.F(f, 2))) ==
        CgalSurface::null_face())
      return std::nullopt;
  }
  for (const auto v : out.vertices()) {
    if (out.is_isolated(v)) out.remove_vertex(v);
  }
  out.collect_garbage();
  return out;
}

SurfaceMesh fromCgal(CgalSurface& surface, std::string name) {
  surface.collect_garbage();
  SurfaceMesh out;
  out.name = std::move(name);
  out.V.resize(static_cast<Eigen::Index>(surface.number_of_vertices()), 3);
  out.F.resize(static_cast<Eigen::Index>(surface.number_of_faces()), 3);
  for (const auto v : surface.vertices()) {
    const CgalKernel::Point_3& p = surface.point(v);
    out.V.row(static_cast<Eigen::Index>(v.idx())) << p.x(), p.y(), p.z();
  }
  for (const auto f : surface.faces()) {
    int k = 0;
    for (const auto v : surface.vertices_around_face(surface.halfedge(f)))
      out.F(static_cast<Eigen::Index>(f.idx()), k++) = static_cast<std::int32_t>(v.idx());
  }
  return out;
}

}  // namespace ecorche::mesh
