#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/border.h>
#include <CGAL/Polygon_mesh_processing/connected_components.h>
#include <CGAL/Polygon_mesh_processing/manifoldness.h>
#include <CGAL/Polygon_mesh_processing/orient_polygon_soup.h>
#include <CGAL/Polygon_mesh_processing/polygon_soup_to_polygon_mesh.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/shape_predicates.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>
#include <ecorche/mesh/hole_fill.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <exception>

namespace ecorche::mesh {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Mesh = CGAL::Surface_mesh<Point>;
using Labels = Mesh::Property_map<Mesh::Face_index, std::int32_t>;

Vector3 toVector(const Point& p) { return {p.x(), p.y(), p.z()}; }

// Faces that a step made have no label yet: they take a neighbour's, from the labelled ones
// outward.
void spreadLabels(const Mesh& mesh, Labels& labels) {
  std::vector<Mesh::Face_index> open;
  for (const auto f : mesh.faces()) {
    if (labels[f] >= 0) continue;
    for (const auto g : mesh.faces_around_face(mesh.halfedge(f))) {
      if (g.is_valid() && g != Mesh::null_face() && labels[g] >= 0) {
        open.push_back(g);
        break;
      }
    }
  }
  while (!open.empty()) {
    const auto f = open.back();
    open.pop_back();
    for (const auto g : mesh.faces_around_face(mesh.halfedge(f))) {
      if (g == Mesh::null_face() || labels[g] >= 0) continue;
      labels[g] = labels[f];
      open.push_back(g);
    }
  }
}

StepReport dropFlat(Mesh& mesh) {
  StepReport report;
  for (const auto f : mesh.faces()) {
    if (!PMP::is_degenerate_triangle_face(f, mesh)) continue;
    report.see(toVector(mesh.point(mesh.target(mesh.halfedge(f)))));
  }
  if (report.count == 0) return report;
  PMP::remove_degenerate_faces(mesh);
  PMP::duplicate_non_manifold_vertices(
      mesh);  // a face that goes at a border may leave two fans behind
  return report;
}

/// The border of a triangle that hangs together with nothing: filling it doubles it.
bool isLoneFace(const Mesh& mesh, Mesh::Halfedge_index border) {
  const auto across = [&](Mesh::Halfedge_index h) { return mesh.face(mesh.opposite(h)); };
  const auto next = mesh.next(border);
  return mesh.next(mesh.next(next)) == border && across(border) == across(next);
}

StepReport fillHoles(Mesh& mesh, double holeRel, RunContext& run) {
  StepReport report;
  std::vector<Mesh::Halfedge_index> cycles;
  PMP::extract_boundary_cycles(mesh, std::back_inserter(cycles));
  if (cycles.empty() || !(holeRel > 0.0)) return report;

  auto piece = mesh.add_property_map<Mesh::Face_index, std::size_t>("f:piece", 0).first;
  std::vector<Box> boxes(PMP::connected_components(mesh, piece));
  for (const auto f : mesh.faces()) {
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f)))
      boxes[piece[f]].add(toVector(mesh.point(v)));
  }
  for (const auto border : cycles) {
    if (run.cancelled()) return report;
    if (isLoneFace(mesh, border)) continue;
    Box box;
    std::size_t edges = 0;
    for (const auto h : mesh.halfedges_around_face(border)) {
      box.add(toVector(mesh.point(mesh.target(h))));
      ++edges;
    }
    const double whole = boxes[piece[mesh.face(mesh.opposite(border))]].diagonal();
    if (!isSmallHole(box.diagonal(), edges, whole, holeRel)) continue;
    // The exhaustive search takes the cube of the border's length
    std::vector<Mesh::Face_index> patch;
    PMP::triangulate_hole(mesh, border, std::back_inserter(patch),
                          CGAL::parameters::do_not_use_cubic_algorithm(edges > 200));
    if (!patch.empty()) report.see(box.centre(), box.diagonal());
  }
  return report;
}

ManifoldReport process(LabelledFaces& faces, double holeRel, RunContext& run) {
  ManifoldReport report;
  std::vector<Point> points;
  points.reserve(static_cast<std::size_t>(faces.V.rows()));
  for (Eigen::Index v = 0; v < faces.V.rows(); ++v)
    points.emplace_back(faces.V(v, 0), faces.V(v, 1), faces.V(v, 2));
  std::vector<std::array<std::size_t, 3>> polygons;
  polygons.reserve(static_cast<std::size_t>(faces.F.rows()));
  for (Eigen::Index f = 0; f < faces.F.rows(); ++f) {
    polygons.push_back({static_cast<std::size_t>(faces.F(f, 0)),
                        static_cast<std::size_t>(faces.F(f, 1)),
                        static_cast<std::size_t>(faces.F(f, 2))});
  }

  const std::size_t before = points.size();
  PMP::orient_polygon_soup(points, polygons);
  for (std::size_t p = before; p < points.size(); ++p) report.split.see(toVector(points[p]));
  Mesh mesh;
  PMP::polygon_soup_to_polygon_mesh(points, polygons, mesh);
  Labels labels = mesh.add_property_map<Mesh::Face_index, std::int32_t>("f:label", -1).first;
  for (const auto f : mesh.faces()) labels[f] = faces.label[f.idx()];

  report.flat = dropFlat(mesh);
  report.filled = fillHoles(mesh, holeRel, run);
  spreadLabels(mesh, labels);

  mesh.collect_garbage();
  faces.V.resize(static_cast<Eigen::Index>(mesh.number_of_vertices()), 3);
  for (const auto v : mesh.vertices()) faces.V.row(v.idx()) = toVector(mesh.point(v)).transpose();
  faces.F.resize(static_cast<Eigen::Index>(mesh.number_of_faces()), 3);
  faces.label.resize(mesh.number_of_faces());
  for (const auto f : mesh.faces()) {
    int k = 0;
    for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
      faces.F(f.idx(), k++) = static_cast<std::int32_t>(v.idx());
    }
    faces.label[f.idx()] = std::max(labels[f], 0);
  }
  return report;
}

}  // namespace

bool isSmallHole(double extent, std::size_t edges, double whole, double holeRel) {
  // The fewer its edges, the surer that a face or two are missing
  constexpr double kFew = 20.0;
  return extent <= std::max(1.0, kFew / static_cast<double>(edges)) * holeRel * whole;
}

Result<ManifoldReport> makeManifold(LabelledFaces& faces, double holeRel, RunContext& run) {
  try {
    ManifoldReport report = process(faces, holeRel, run);
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "repair was interrupted");
    return report;
  } catch (const std::exception& e) {
    return fail(
        ErrorCode::MeshNotRepairable,
        fmt::format("the surface cannot be made a manifold ({}); clean it where it was made",
                    e.what()));
  }
}

}  // namespace ecorche::mesh
