#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>
#include <ecorche/domain/carve.h>
#include <ecorche/domain/wrap.h>
#include <fmt/format.h>

#include <array>

namespace ecorche::domain {

namespace {
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Triangle = Kernel::Triangle_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Iterator = std::vector<Triangle>::const_iterator;
using Tree =
    CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Iterator>>>;
}  // namespace

Result<TaggedSurface> wrap(const std::vector<const Hole*>& holes, double tolerance,
                           RunContext& run) {
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "wrapping bones");
  std::vector<Point> points;
  std::vector<std::array<std::size_t, 3>> faces;
  std::vector<Triangle> triangles;
  std::vector<std::int32_t> tags;
  for (const Hole* hole : holes) {
    const std::size_t first = points.size();
    const auto& V = hole->mesh.V;
    const auto& F = hole->mesh.F;
    for (Eigen::Index v = 0; v < V.rows(); ++v) points.emplace_back(V(v, 0), V(v, 1), V(v, 2));
    for (Eigen::Index f = 0; f < F.rows(); ++f) {
      std::array<std::size_t, 3> face{};
      for (int k = 0; k < 3; ++k)
        face[static_cast<std::size_t>(k)] = first + static_cast<std::size_t>(F(f, k));
      const Triangle triangle(points[face[0]], points[face[1]], points[face[2]]);
      if (triangle.is_degenerate()) continue;
      faces.push_back(face);
      triangles.push_back(triangle);
      tags.push_back(packed(hole->tag));
    }
  }
  if (triangles.empty()) {
    return fail(ErrorCode::MeshNotRepairable,
                fmt::format("\"{}\" has no triangle of positive area", holes.front()->name),
                {.object = holes.front()->name});
  }

  Mesh wrapped;
  CGAL::alpha_wrap_3(points, faces, tolerance, tolerance / 3.0, wrapped);

  Tree tree(triangles.begin(), triangles.end());
  tree.accelerate_distance_queries();
  TaggedSurface out;
  out.V.resize(static_cast<Eigen::Index>(wrapped.number_of_vertices()), 3);
  out.F.resize(static_cast<Eigen::Index>(wrapped.number_of_faces()), 3);
  for (const auto v : wrapped.vertices()) {
    const Point& p = wrapped.point(v);
    out.V.row(static_cast<Eigen::Index>(v.idx())) << p.x(), p.y(), p.z();
  }
  for (const auto f : wrapped.faces()) {
    std::array<Point, 3> corner;
    std::size_t k = 0;
    for (const auto v : wrapped.vertices_around_face(wrapped.halfedge(f))) {
      out.F(static_cast<Eigen::Index>(f.idx()), static_cast<Eigen::Index>(k)) =
          static_cast<std::int32_t>(v.idx());
      corner[k++] = wrapped.point(v);
    }
    const auto closest =
        tree.closest_point_and_primitive(CGAL::centroid(corner[0], corner[1], corner[2])).second;
    out.tag.push_back(tags[static_cast<std::size_t>(closest - triangles.cbegin())]);
  }
  return out;
}

}  // namespace ecorche::domain
