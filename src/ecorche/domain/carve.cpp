#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/intersection.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <ecorche/domain/carve.h>
#include <ecorche/domain/null_edges.h>
#include <ecorche/domain/pockets.h>
#include <ecorche/domain/wrap.h>
#include <ecorche/mesh/cgal_surface.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/tips.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <unordered_map>

namespace ecorche::domain {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Kernel = mesh::CgalKernel;
using Point = Kernel::Point_3;
using Mesh = mesh::CgalSurface;
using TagMap = Mesh::Property_map<Mesh::Face_index, std::int32_t>;
constexpr double kHairShare = 0.02;  // of the wrap tolerance

using Inside = CGAL::Side_of_triangle_mesh<Mesh, Kernel>;

TagMap tagsOf(Mesh& mesh) {
  return mesh.add_property_map<Mesh::Face_index, std::int32_t>("f:tag", 0).first;
}

/// Nothing for what is not an oriented manifold.
std::optional<Mesh> toCgal(const TaggedSurface& surface) {
  auto mesh = mesh::toCgal({.V = surface.V, .F = surface.F});
  if (!mesh) return std::nullopt;
  TagMap tags = tagsOf(*mesh);
  for (const auto f : mesh->faces()) tags[f] = surface.tag[f.idx()];
  return mesh;
}

TaggedSurface fromCgal(Mesh& mesh) {
  mesh::SurfaceMesh plain = mesh::fromCgal(mesh, {});
  TagMap tags = tagsOf(mesh);
  TaggedSurface out{std::move(plain.V), std::move(plain.F), {}};
  for (const auto f : mesh.faces()) out.tag.push_back(tags[f]);
  return out;
}

/// Hands the tag of a face on to the pieces that corefinement makes of it.
struct TagVisitor : PMP::Corefinement::Default_visitor<Mesh> {
  struct State {
    std::unordered_map<const Mesh*, TagMap> maps;
    std::int32_t splitting = 0;
  };
  std::shared_ptr<State> state = std::make_shared<State>();

  void know(Mesh& mesh) { state->maps.insert_or_assign(&mesh, tagsOf(mesh)); }
  void before_subface_creations(Mesh::Face_index f, Mesh& mesh) {
    state->splitting = state->maps.at(&mesh)[f];
  }
  void after_subface_created(Mesh::Face_index f, Mesh& mesh) {
    state->maps.at(&mesh)[f] = state->splitting;
  }
  void after_face_copy(Mesh::Face_index from, const Mesh& source, Mesh::Face_index to,
                       Mesh& target) {
    state->maps.at(&target)[to] = state->maps.at(&source)[from];
  }
};

enum class Operation { Union, Difference, Intersection };

/// a := a op b with tags. False, and a untouched, where the result would not be a manifold or the
/// library gives up.
bool combine(Mesh& a, const Mesh& b, Operation operation) {
  Mesh left = a;
  Mesh right = b;
  Mesh out;
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

/// The half space of a cut plane as a box so large that only its first face matters.
Mesh halfSpace(const CutPlane& plane, std::int32_t tag, double size) {
  const mesh::Vector3 n = plane.normal.normalized();
  // For a normal along an axis u and v are axes too, and the corners lie on the plane exactly
  int least = 0;
  n.cwiseAbs().minCoeff(&least);
  const mesh::Vector3 u = n.cross(mesh::Vector3::Unit(least)).normalized();
  const mesh::Vector3 v = n.cross(u);
  Mesh box;
  std::vector<Mesh::Vertex_index> corner;
  for (const double height : {0.0, size}) {
    for (const auto& [a, b] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      const mesh::Vector3 p = plane.point + a * size * u + b * size * v + height * n;
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

/// Corefinement meets edges and faces in an order that depends on memory, and the last digits of
/// what it makes with it. 2⁻⁴² of the size is far below any tolerance and far above those digits.
void roundPositions(mesh::Positions& V, double size) {
  const double grid = std::exp2(std::floor(std::log2(size)) - 42.0);
  V = (V / grid).array().round() * grid;
}

/// Puts the vertices of the faces on cut plane `tag` onto it.
void snapToPlane(TaggedSurface& surface, const CutPlane& plane, std::int32_t tag) {
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f) {
    if (surface.tag[static_cast<std::size_t>(f)] != tag) continue;
    for (int k = 0; k < 3; ++k) {
      const auto v = surface.F(f, k);
      surface.V.row(v) = ontoPlane(plane, surface.V.row(v).transpose()).transpose();
    }
  }
}

mesh::Vector3 anyPoint(const Mesh& mesh) {
  const Point& p = mesh.point(*mesh.vertices().begin());
  return {p.x(), p.y(), p.z()};
}

/// One hole on its way into the domain.
struct Item {
  const Hole* hole = nullptr;
  std::optional<Mesh> mesh;
  CGAL::Bbox_3 box;
};

/// Groups of items whose surfaces meet, or of which one holds another.
std::vector<std::vector<std::size_t>> clustersOf(const std::vector<Item>& items) {
  std::vector<std::size_t> root(items.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  std::vector<std::unique_ptr<Inside>> inside(items.size());
  const auto holds = [&](std::size_t outer, std::size_t inner) {
    if (!inside[outer]) inside[outer] = std::make_unique<Inside>(*items[outer].mesh);
    const auto p = items[inner].mesh->point(*items[inner].mesh->vertices().begin());
    return (*inside[outer])(p) != CGAL::ON_UNBOUNDED_SIDE;
  };
  for (std::size_t i = 0; i < items.size(); ++i) {
    for (std::size_t j = i + 1; j < items.size(); ++j) {
      if (find(i) == find(j) || !CGAL::do_overlap(items[i].box, items[j].box)) continue;
      if (PMP::do_intersect(*items[i].mesh, *items[j].mesh) || holds(i, j) || holds(j, i)) {
        root[std::max(find(i), find(j))] = std::min(find(i), find(j));
      }
    }
  }
  std::vector<std::vector<std::size_t>> clusters;
  std::unordered_map<std::size_t, std::size_t> slot;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const auto [it, fresh] = slot.try_emplace(find(i), clusters.size());
    if (fresh) clusters.emplace_back();
    clusters[it->second].push_back(i);
  }
  return clusters;
}

std::string namesOf(const std::vector<Item>& items, const std::vector<std::size_t>& cluster) {
  std::string names;
  for (const std::size_t i : cluster) {
    if (!names.empty()) names += ", ";
    names += items[i].hole->name;
  }
  return names;
}

bool beyondCutPlane(const mesh::SurfaceMesh& mesh, const CutPlane& plane) {
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    if (plane.normal.dot(mesh.V.row(v).transpose() - plane.point) > 0.0) return false;
  }
  return true;
}

/// Bones of the midline have walls that a symmetry plane runs along within rounding, and cutting
/// there leaves films that no resampling can keep apart. So what reaches no farther than a hair
/// over the plane is moved behind it, and everything behind it by as much: nothing folds.
void clearOfPlane(mesh::SurfaceMesh& mesh, const CutPlane& plane, double hair) {
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    if (plane.normal.dot(mesh.V.row(v).transpose() - plane.point) < hair)
      mesh.V.row(v) -= 2.0 * hair * plane.normal.transpose();
  }
}

class Carver {
 public:
  Carver(const CarveInput& input, const CarveOptions& options, RunContext& run)
      : input_(input),
        options_(options),
        run_(run),
        size_(4.0 * mesh::boundingBox(input.skin).diagonal()) {}

  Result<Carved> operator()() {
    auto skin = toCgal(tagged(input_.skin, {BoundaryTag::Kind::Skin, 0}));
    if (!skin) {
      return fail(ErrorCode::MeshNotRepairable, "the skin is not a manifold surface",
                  {.object = input_.skin.name});
    }
    skin_ = std::move(*skin);
    if (auto gathered = gatherHoles(); !gathered) return passOn(gathered);
    if (auto cut = cutAtPlanes(); !cut) return passOn(cut);
    if (auto taken = takeHolesOut(); !taken) return passOn(taken);
    if (skin_.number_of_faces() == 0) {
      return fail(ErrorCode::EmptyDomain,
                  "nothing is left of the skin after bones and cut planes were taken away",
                  {.object = input_.skin.name});
    }
    out_.surface = fromCgal(skin_);
    roundPositions(out_.surface.V, size_);
    out_.surface = withoutNullEdges(out_.surface);
    if (mesh::drawTipsApart(out_.surface.V, out_.surface.F) > 0)
      roundPositions(out_.surface.V, size_);
    // Corefinement numbers new vertices by what lies where in memory
    out_.surface = ordered(out_.surface);
    // Last: every cut that meets a plane leaves rounded vertices on it
    for (std::size_t k = 0; k < input_.cutPlanes.size(); ++k) {
      snapToPlane(out_.surface, input_.cutPlanes[k],
                  packed({BoundaryTag::Kind::CutPlane, static_cast<std::int32_t>(k)}));
    }
    leavePocketsOut();
    std::ranges::sort(out_.wrapped);
    const auto repeated = std::ranges::unique(out_.wrapped);
    out_.wrapped.erase(repeated.begin(), repeated.end());
    return std::move(out_);
  }

 private:
  void note(Severity severity, std::string kind, std::string object, std::string message,
            std::optional<mesh::Vector3> point = {}, double size = 0.0) {
    out_.findings.push_back(
        {severity, std::move(kind), std::move(object), std::move(message), point, size});
  }

  /// Marrow, and what bones close in: no fat could reach it.
  void leavePocketsOut() {
    struct Of {
      std::vector<std::string> names;
      double volume = 0.0;
      int count = 0;
      Pocket largest;
    };
    std::map<std::vector<std::int32_t>, Of> byWalls;
    for (Pocket& pocket : dropPockets(out_.surface)) {
      Of& of = byWalls[pocket.tags];
      of.volume += pocket.volume;
      if (++of.count == 1 || pocket.volume > of.largest.volume) of.largest = std::move(pocket);
    }
    for (auto& [tags, of] : byWalls) {
      for (const std::int32_t tag : tags) {
        const auto hole =
            std::ranges::find_if(input_.holes, [&](const Hole& h) { return packed(h.tag) == tag; });
        if (hole != input_.holes.end()) of.names.push_back(hole->name);
      }
      const bool one = of.count == 1;
      note(Severity::Warning, "closed-pocket", of.names.empty() ? "" : of.names.front(),
           fmt::format("{}{:.3g} cm³ closed in by {} touch no skin and were left out; a tissue in "
                       "there would need a way out to the skin",
                       one ? "" : fmt::format("{} pockets, in all ", of.count), of.volume * 1e6,
                       fmt::join(of.names, ", ")),
           of.largest.place, of.volume);
    }
  }

  /// Leaves out what lies beyond a cut plane or outside the skin, and measures what pokes out.
  Result<void> gatherHoles() {
    const Inside insideSkin(skin_);
    const CGAL::Bbox_3 skinBox = PMP::bbox(skin_);
    int boneCount = 0;
    int outsideCount = 0;
    for (const Hole& hole : input_.holes) {
      if (run_.cancelled()) return fail(ErrorCode::Cancelled, "carving the domain");
      const bool beyond = std::ranges::any_of(input_.cutPlanes, [&](const CutPlane& plane) {
        return beyondCutPlane(hole.mesh, plane);
      });
      const bool bone = hole.tag.kind == BoundaryTag::Kind::Bone;
      boneCount += bone;
      if (beyond) {
        out_.leftOut.push_back(hole.name);
        continue;
      }
      Item item{&hole, toCgal(tagged(hole.mesh, hole.tag)), {}};
      if (!item.mesh || !hole.fit) {
        auto wrapped = wrapHoles({&hole});
        if (!wrapped) return passOn(wrapped);
        item.mesh = std::move(*wrapped);
      }
      item.box = PMP::bbox(*item.mesh);
      const bool crosses =
          CGAL::do_overlap(item.box, skinBox) && PMP::do_intersect(*item.mesh, skin_);
      const auto first = item.mesh->point(*item.mesh->vertices().begin());
      if (!crosses && insideSkin(first) == CGAL::ON_UNBOUNDED_SIDE) {
        // Around the skin is not outside it
        const auto skinPoint = skin_.point(*skin_.vertices().begin());
        if (Inside(*item.mesh)(skinPoint) == CGAL::ON_BOUNDED_SIDE) {
          return fail(ErrorCode::EmptyDomain,
                      fmt::format("\"{}\" encloses the whole skin, so nothing is left of it; check "
                                  "the units and the frame of both",
                                  hole.name),
                      {.object = hole.name, .point = anyPoint(*item.mesh)});
        }
        outsideCount += bone;
        out_.leftOut.push_back(hole.name);
        note(Severity::Warning, "outside-skin", hole.name,
             fmt::format("\"{}\" lies outside the skin and was left out", hole.name),
             anyPoint(*item.mesh));
        continue;
      }
      if (crosses) reportPokingOut(item);
      items_.push_back(std::move(item));
    }
    if (boneCount > 0 && outsideCount == boneCount) {
      const bool hollow = std::ranges::any_of(mesh::checkSurface(input_.skin).components,
                                              &mesh::SurfaceCheck::Component::inward);
      return fail(
          ErrorCode::BonesOutsideSkin,
          fmt::format("{} outside the skin; {}",
                      boneCount == 1
                          ? fmt::format("the only bone, \"{}\", lies", out_.leftOut.back())
                          : fmt::format("all {} bones lie", boneCount),
                      hollow ? "it is hollow, an inner layer faces inward: ask for \"repair\": "
                               "\"outer-hull\" at the skin"
                             : "check the units and the frame of skin and bones"),
          {.object = input_.skin.name, .point = out_.findings.back().point});
    }
    return {};
  }

  void reportPokingOut(const Item& item) {
    Mesh outside = *item.mesh;
    const double whole = CGAL::to_double(PMP::volume(outside));
    double volume = 0.0;
    if (combine(outside, skin_, Operation::Difference)) {
      volume = CGAL::to_double(PMP::volume(outside));
    }
    if (volume <= 0.0 || outside.number_of_vertices() == 0) return;
    note(Severity::Repaired, "pokes-out", item.hole->name,
         fmt::format(
             "\"{}\" reaches out of the skin with {:.3g} cm³ of its {:.3g} cm³; cut off there",
             item.hole->name, volume * 1e6, whole * 1e6),
         anyPoint(outside), volume);
  }

  Result<Mesh> wrapHoles(const std::vector<const Hole*>& holes) {
    auto surface = wrap(holes, options_.wrapTolerance, run_);
    if (!surface) return passOn(surface);
    auto mesh = toCgal(*surface);
    if (!mesh || mesh->number_of_faces() == 0) {
      return fail(
          ErrorCode::MeshNotRepairable,
          fmt::format("\"{}\" cannot be wrapped into a closed surface", holes.front()->name),
          {.object = holes.front()->name});
    }
    ++out_.wrapCount;
    for (const Hole* hole : holes) {
      out_.wrapped.push_back(static_cast<std::size_t>(hole - input_.holes.data()));
    }
    std::string names;
    for (const Hole* hole : holes) names += (names.empty() ? "" : ", ") + hole->name;
    note(Severity::Repaired, "wrapped", holes.front()->name,
         fmt::format("{} had to be wrapped (open, self-intersecting or touching); the wrap strays "
                     "by at most {:.3g} mm",
                     names, options_.wrapTolerance * 1e3),
         anyPoint(*mesh), options_.wrapTolerance);
    return std::move(*mesh);
  }

  Result<void> cutAtPlanes() {
    for (std::size_t k = 0; k < input_.cutPlanes.size(); ++k) {
      if (run_.cancelled()) return fail(ErrorCode::Cancelled, "carving the domain");
      const std::int32_t tag = packed({BoundaryTag::Kind::CutPlane, static_cast<std::int32_t>(k)});
      // A plane through vertices or edges of the skin may leave a result that touches itself. Moved
      // by a hair it does not; the vertices are put back onto the true plane afterwards.
      bool done = false;
      for (const double shift : {0.0, 1e-8, -1e-8, 1e-6}) {
        CutPlane plane = input_.cutPlanes[k];
        plane.point += shift * size_ * plane.normal;
        if (combine(skin_, halfSpace(plane, tag, size_), Operation::Intersection)) {
          done = true;
          break;
        }
      }
      if (!done) {
        return fail(
            ErrorCode::MeshNotRepairable,
            fmt::format("the skin cannot be cut at plane \"{}\"; it intersects itself there",
                        input_.cutPlanes[k].name),
            {.object = input_.skin.name});
      }
      if (skin_.number_of_faces() == 0) {
        return fail(ErrorCode::EmptyDomain,
                    fmt::format("nothing of the skin lies on the kept side of cut plane \"{}\"",
                                input_.cutPlanes[k].name),
                    {.object = input_.cutPlanes[k].name});
      }
    }
    return {};
  }

  /// One closed surface from a cluster, exact where possible.
  Result<Mesh> united(const std::vector<std::size_t>& cluster) {
    Mesh sum = *items_[cluster.front()].mesh;
    bool exact = true;
    for (std::size_t k = 1; k < cluster.size() && exact; ++k) {
      exact = combine(sum, *items_[cluster[k]].mesh, Operation::Union);
    }
    if (exact) return sum;
    std::vector<const Hole*> holes;
    for (const std::size_t i : cluster) holes.push_back(items_[i].hole);
    return wrapHoles(holes);
  }

  Result<void> takeHolesOut() {
    if (items_.empty()) return {};
    Mesh all;
    tagsOf(all);
    std::vector<Mesh> sums;
    const auto clusters = clustersOf(items_);
    for (const auto& cluster : clusters) {
      if (run_.cancelled()) return fail(ErrorCode::Cancelled, "carving the domain");
      auto sum = united(cluster);
      if (!sum) return passOn(sum);
      if (cluster.size() > 1) {
        note(Severity::Note, "united", items_[cluster.front()].hole->name,
             fmt::format("{} touch or overlap and were united", namesOf(items_, cluster)),
             anyPoint(*sum), static_cast<double>(cluster.size()));
      }
      all += *sum;
      sums.push_back(std::move(*sum));
    }
    if (combine(skin_, all, Operation::Difference)) return {};

    // Something in there defeats the exact way: take clusters out one at a time and wrap the
    // culprits
    for (std::size_t c = 0; c < sums.size(); ++c) {
      if (run_.cancelled()) return fail(ErrorCode::Cancelled, "carving the domain");
      if (combine(skin_, sums[c], Operation::Difference)) continue;
      std::vector<const Hole*> holes;
      for (const std::size_t i : clusters[c]) holes.push_back(items_[i].hole);
      auto wrapped = wrapHoles(holes);
      if (!wrapped) return passOn(wrapped);
      if (!combine(skin_, *wrapped, Operation::Difference)) {
        return fail(ErrorCode::MeshNotRepairable,
                    fmt::format("{} cannot be taken out of the skin", namesOf(items_, clusters[c])),
                    {.object = holes.front()->name, .point = anyPoint(*wrapped)});
      }
    }
    return {};
  }

  const CarveInput& input_;
  const CarveOptions& options_;
  RunContext& run_;
  double size_;
  Mesh skin_;
  std::vector<Item> items_;
  Carved out_;
};

}  // namespace

Result<Carved> carve(const CarveInput& input, const CarveOptions& options, RunContext& run) {
  const Stage stage(run, "domain: carve");
  if (input.cutPlanes.empty()) return Carver(input, options, run)();
  CarveInput clear = input;
  for (const CutPlane& plane : input.cutPlanes) {
    const double hair = kHairShare * options.wrapTolerance;
    clearOfPlane(clear.skin, plane, hair);
    for (Hole& hole : clear.holes) clearOfPlane(hole.mesh, plane, hair);
  }
  return Carver(clear, options, run)();
}

}  // namespace ecorche::domain
