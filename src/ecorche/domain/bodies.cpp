#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Polygon_mesh_processing/intersection.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <ecorche/domain/bodies.h>
#include <ecorche/domain/wrap.h>
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <unordered_map>

namespace ecorche::domain {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = mesh::CgalKernel;
using Inside = CGAL::Side_of_triangle_mesh<TaggedMesh, Kernel>;
using Group = std::vector<std::size_t>;

/// Groups of bodies whose surfaces meet, or of which one holds another.
std::vector<Group> groupsOf(const std::vector<Body>& bodies) {
  std::vector<std::size_t> root(bodies.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<CGAL::Bbox_3> box;
  for (const Body& body : bodies) box.push_back(PMP::bbox(body.mesh));
  std::vector<std::unique_ptr<Inside>> inside(bodies.size());
  const auto holds = [&](std::size_t outer, std::size_t inner) {
    if (!inside[outer]) inside[outer] = std::make_unique<Inside>(bodies[outer].mesh);
    const auto p = bodies[inner].mesh.point(*bodies[inner].mesh.vertices().begin());
    return (*inside[outer])(p) != CGAL::ON_UNBOUNDED_SIDE;
  };
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      if (find(i) == find(j) || !CGAL::do_overlap(box[i], box[j])) continue;
      if (PMP::do_intersect(bodies[i].mesh, bodies[j].mesh) || holds(i, j) || holds(j, i))
        root[std::max(find(i), find(j))] = std::min(find(i), find(j));
    }
  }
  std::vector<Group> groups;
  std::unordered_map<std::size_t, std::size_t> slot;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto [it, fresh] = slot.try_emplace(find(i), groups.size());
    if (fresh) groups.emplace_back();
    groups[it->second].push_back(i);
  }
  return groups;
}

/// Every vertex moved outward along its normal; nothing where the mesh would cut itself after that.
std::optional<TaggedMesh> grown(const TaggedMesh& mesh, double by) {
  TaggedMesh out = mesh;
  for (const auto v : mesh.vertices())
    out.point(v) = mesh.point(v) + by * PMP::compute_vertex_normal(v, mesh);
  if (PMP::does_self_intersect(out)) return std::nullopt;
  return out;
}

/// Those of the group as one, or nothing. One that cannot join yet may do so once others have.
/// @param grew  gets the holes of bodies that had to be grown
std::optional<TaggedMesh> exactUnion(const std::vector<Body>& bodies, const Group& group, double by,
                                     std::vector<const Hole*>& grew) {
  TaggedMesh sum = bodies[group.front()].mesh;
  Group left(group.begin() + 1, group.end());
  while (!left.empty()) {
    const auto joins = [&](std::size_t i) {
      const TaggedMesh& mesh = bodies[i].mesh;
      if (combine(sum, mesh, Operation::Union)) return true;
      const auto larger = grown(mesh, by);
      if (!larger || !combine(sum, *larger, Operation::Union)) return false;
      grew.insert(grew.end(), bodies[i].holes.begin(), bodies[i].holes.end());
      return true;
    };
    const std::size_t before = left.size();
    std::erase_if(left, joins);
    if (left.size() == before) return std::nullopt;
  }
  return sum;
}

Result<Body> united(const std::vector<Body>& bodies, const Group& group, double wrapTolerance,
                    RunContext& run) {
  Body out;
  for (const std::size_t i : group) {
    out.holes.insert(out.holes.end(), bodies[i].holes.begin(), bodies[i].holes.end());
    out.wrapped.insert(out.wrapped.end(), bodies[i].wrapped.begin(), bodies[i].wrapped.end());
    out.grown.insert(out.grown.end(), bodies[i].grown.begin(), bodies[i].grown.end());
  }
  std::optional<TaggedMesh> sum = exactUnion(bodies, group, growth(wrapTolerance), out.grown);
  if (!sum) return wrapBody(out.holes, wrapTolerance, run);
  out.mesh = std::move(*sum);
  return out;
}

}  // namespace

std::string namesOf(const std::vector<const Hole*>& holes) {
  std::string names;
  for (const Hole* hole : holes) names += (names.empty() ? "" : ", ") + hole->name;
  return names;
}

Result<Body> bodyOf(const Hole& hole, double wrapTolerance, RunContext& run) {
  if (hole.fit) {
    if (auto mesh = toCgal(tagged(hole.mesh, hole.tag)))
      return Body{{&hole}, {}, {}, std::move(*mesh)};
  }
  return wrapBody({&hole}, wrapTolerance, run);
}

Result<Body> wrapBody(const std::vector<const Hole*>& holes, double wrapTolerance,
                      RunContext& run) {
  auto surface = wrap(holes, wrapTolerance, run);
  if (!surface) return passOn(surface);
  auto mesh = toCgal(*surface);
  if (!mesh || mesh->number_of_faces() == 0) {
    return fail(ErrorCode::MeshNotRepairable,
                fmt::format("\"{}\" cannot be wrapped into a closed surface", holes.front()->name),
                {.object = holes.front()->name});
  }
  return Body{holes, holes, {}, std::move(*mesh)};
}

Result<std::vector<Body>> unitedBodies(std::vector<Body> bodies, double wrapTolerance,
                                       RunContext& run) {
  for (;;) {
    const std::vector<Group> groups = groupsOf(bodies);
    if (groups.size() == bodies.size()) return bodies;
    std::vector<Body> next;
    for (const Group& group : groups) {
      if (run.cancelled()) return fail(ErrorCode::Cancelled, "carving the domain");
      if (group.size() == 1) {
        next.push_back(std::move(bodies[group.front()]));
        continue;
      }
      auto body = united(bodies, group, wrapTolerance, run);
      if (!body) return passOn(body);
      next.push_back(std::move(*body));
    }
    bodies = std::move(next);
  }
}

}  // namespace ecorche::domain
