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
#include <span>
#include <unordered_map>

namespace ecorche::domain {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = mesh::CgalKernel;
using Inside = CGAL::Side_of_triangle_mesh<TaggedMesh, Kernel>;
using Group = std::vector<std::size_t>;

/// Groups of bodies whose surfaces meet, or of which one holds a piece of another.
std::vector<Group> groupsOf(const std::vector<Body>& bodies, RunContext& run) {
  std::vector<std::size_t> root(bodies.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<CGAL::Bbox_3> box;
  std::vector<std::vector<Kernel::Point_3>> points;  // one of each piece
  for (const Body& body : bodies) {
    box.push_back(PMP::bbox(body.mesh));
    points.push_back(pointsOfPieces(body.mesh));
  }
  std::vector<std::unique_ptr<Inside>> inside(bodies.size());
  const auto holds = [&](std::size_t outer, std::size_t inner) {
    if (!inside[outer]) inside[outer] = std::make_unique<Inside>(bodies[outer].mesh);
    return std::ranges::any_of(points[inner], [&](const auto& p) {
      return (*inside[outer])(p) != CGAL::ON_UNBOUNDED_SIDE;
    });
  };
  for (std::size_t i = 0; i < bodies.size() && !run.cancelled(); ++i) {
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

/// Some bodies that joined.
struct Sum {
  TaggedMesh mesh;
  Group members;
};

/// Halves of halves, so that most unions are small. What does not join as it is stays apart.
std::vector<Sum> sumsOf(const std::vector<Body>& bodies, std::span<const std::size_t> group,
                        RunContext& run) {
  if (group.size() == 1) return {{bodies[group.front()].mesh, {group.front()}}};
  const std::size_t half = group.size() / 2;
  std::vector<Sum> out = sumsOf(bodies, group.first(half), run);
  for (Sum& other : sumsOf(bodies, group.subspan(half), run)) {
    const auto home = std::ranges::find_if(out, [&](Sum& sum) {
      return !run.cancelled() && combine(sum.mesh, other.mesh, Operation::Union);
    });
    if (home == out.end()) {
      out.push_back(std::move(other));
    } else {
      home->members.insert(home->members.end(), other.members.begin(), other.members.end());
    }
  }
  return out;
}

/// Those of the group as one, or nothing. One that cannot join yet may do so once others have.
/// @param grew  gets the holes of bodies that had to be grown
std::optional<TaggedMesh> exactUnion(const std::vector<Body>& bodies, const Group& group, double by,
                                     std::vector<const Hole*>& grew, RunContext& run) {
  std::vector<Sum> sums = sumsOf(bodies, group, run);
  TaggedMesh sum = std::move(sums.front().mesh);
  Group left;
  for (std::size_t s = 1; s < sums.size(); ++s)
    left.insert(left.end(), sums[s].members.begin(), sums[s].members.end());
  while (!left.empty()) {
    const auto joins = [&](std::size_t i) {
      if (run.cancelled()) return false;
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
  std::optional<TaggedMesh> sum = exactUnion(bodies, group, growth(wrapTolerance), out.grown, run);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "uniting bones");
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
    const std::vector<Group> groups = groupsOf(bodies, run);
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "uniting bones");
    if (groups.size() == bodies.size()) return bodies;
    std::vector<Body> next;
    for (const Group& group : groups) {
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
