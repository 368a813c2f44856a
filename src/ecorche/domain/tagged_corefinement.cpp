#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/boost/graph/Euler_operations.h>
#include <ecorche/domain/tagged_corefinement.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <unordered_map>

namespace ecorche::domain {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Point = mesh::CgalKernel::Point_3;

/// Hands the tag of a face on to the pieces that corefinement makes of it.
struct TagVisitor : PMP::Corefinement::Default_visitor<TaggedMesh> {
  struct State {
    std::unordered_map<const TaggedMesh*, TagMap> maps;
    std::int32_t splitting = 0;
  };
  std::shared_ptr<State> state = std::make_shared<State>();

  void know(TaggedMesh& mesh) { state->maps.insert_or_assign(&mesh, tagsOf(mesh)); }
  void before_subface_creations(TaggedMesh::Face_index f, TaggedMesh& mesh) {
    state->splitting = state->maps.at(&mesh)[f];
  }
  void after_subface_created(TaggedMesh::Face_index f, TaggedMesh& mesh) {
    state->maps.at(&mesh)[f] = state->splitting;
  }
  void after_face_copy(TaggedMesh::Face_index from, const TaggedMesh& source,
                       TaggedMesh::Face_index to, TaggedMesh& target) {
    state->maps.at(&target)[to] = state->maps.at(&source)[from];
  }
};

}  // namespace

TagMap tagsOf(TaggedMesh& mesh) {
  return mesh.add_property_map<TaggedMesh::Face_index, std::int32_t>("f:tag", 0).first;
}

std::optional<TaggedMesh> toCgal(const TaggedSurface& surface) {
  auto mesh = mesh::toCgal({.V = surface.V, .F = surface.F});
  if (!mesh) return std::nullopt;
  TagMap tags = tagsOf(*mesh);
  for (const auto f : mesh->faces()) tags[f] = surface.tag[f.idx()];
  return mesh;
}

TaggedSurface fromCgal(TaggedMesh& mesh) {
  mesh::SurfaceMesh plain = mesh::fromCgal(mesh, {});
  TagMap tags = tagsOf(mesh);
  TaggedSurface out{std::move(plain.V), std::move(plain.F), {}};
  for (const auto f : mesh.faces()) out.tag.push_back(tags[f]);
  return out;
}

bool combine(TaggedMesh& a, const TaggedMesh& b, Operation operation) {
  TaggedMesh left = a;
  TaggedMesh right = b;
  TaggedMesh out;
  TagVisitor visitor;
  visitor.know(left);
  visitor.know(right);
  visitor.know(out);
  const auto np1 = CGAL::parameters::visitor(visitor).throw_on_self_intersection(true);
  bool valid = false;
  try {
    switch (operation) {
      case Operation::Union:
        valid = PMP::corefine_and_compute_union(left, right, out, np1);
        break;
      case Operation::Difference:
        valid = PMP::corefine_and_compute_difference(left, right, out, np1);
        break;
      case Operation::Intersection:
        valid = PMP::corefine_and_compute_intersection(left, right, out, np1);
        break;
    }
  } catch (const std::exception&) {
    // Self-intersection found on the way, or a precondition that bad geometry breaks
    return false;
  }
  if (!valid) return false;
  a = std::move(out);
  return true;
}

TaggedMesh halfSpace(const CutPlane& plane, std::int32_t tag, const mesh::Box& around) {
  const mesh::Vector3 n = plane.normal;
  // For a normal along an axis u and v are axes too, and the corners lie on the plane exactly
  int least = 0;
  n.cwiseAbs().minCoeff(&least);
  const mesh::Vector3 u = n.cross(mesh::Vector3::Unit(least)).normalized();
  const mesh::Vector3 v = n.cross(u);
  const double size = 4.0 * around.diagonal();
  const mesh::Vector3 foot = ontoPlane(plane, around.centre());
  const double top = size + std::max(0.0, n.dot(around.centre() - foot));
  TaggedMesh box;
  std::vector<TaggedMesh::Vertex_index> corner;
  for (const double height : {0.0, top}) {
    for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      const mesh::Vector3 p = foot + a * size * u + b * size * v + height * n;
      corner.push_back(box.add_vertex(Point(p.x(), p.y(), p.z())));
    }
  }
  TagMap tags = tagsOf(box);
  constexpr int kFaces[12][3] = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                                 {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  const bool mirrored = u.cross(v).dot(n) < 0;
  for (const auto& f : kFaces) {
    const auto face = mirrored ? box.add_face(corner[f[0]], corner[f[2]], corner[f[1]])
                               : box.add_face(corner[f[0]], corner[f[1]], corner[f[2]]);
    tags[face] = tag;
  }
  return box;
}

MeshPieces piecesOf(const TaggedMesh& mesh) {
  MeshPieces out;
  out.label.assign(mesh.num_faces(), -1);
  std::vector<TaggedMesh::Face_index> open;
  for (const auto seed : mesh.faces()) {
    if (out.label[seed.idx()] >= 0) continue;
    const auto piece = static_cast<std::int32_t>(out.faces.size());
    auto& own = out.faces.emplace_back();
    out.label[seed.idx()] = piece;
    open.push_back(seed);
    while (!open.empty()) {
      const auto f = open.back();
      open.pop_back();
      own.push_back(f);
      for (const auto g : mesh.faces_around_face(mesh.halfedge(f))) {
        if (g == TaggedMesh::null_face() || out.label[g.idx()] >= 0) continue;
        out.label[g.idx()] = piece;
        open.push_back(g);
      }
    }
  }
  return out;
}

std::vector<Point> pointsOfPieces(const TaggedMesh& mesh) {
  std::vector<Point> out;
  for (const auto& faces : piecesOf(mesh).faces)
    out.push_back(mesh.point(mesh.target(mesh.halfedge(faces.front()))));
  return out;
}

TaggedMesh keepPieces(TaggedMesh mesh, const MeshPieces& pieces, const std::vector<char>& kept) {
  for (std::size_t p = 0; p < kept.size(); ++p) {
    if (kept[p] != 0) continue;
    for (const auto f : pieces.faces[p]) CGAL::Euler::remove_face(mesh.halfedge(f), mesh);
  }
  mesh.collect_garbage();
  return mesh;
}

mesh::Vector3 anyPoint(const TaggedMesh& mesh) {
  const Point& p = mesh.point(*mesh.vertices().begin());
  return {p.x(), p.y(), p.z()};
}

}  // namespace ecorche::domain
