#include <CGAL/AABB_face_graph_triangle_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <ecorche/domain/bodies.h>
#include <ecorche/domain/carve.h>
#include <ecorche/domain/null_edges.h>
#include <ecorche/domain/pockets.h>
#include <ecorche/domain/tagged_corefinement.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_contact.h>
#include <ecorche/mesh/tips.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>

namespace ecorche::domain {

namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
using Inside = CGAL::Side_of_triangle_mesh<TaggedMesh, mesh::CgalKernel>;
using Tree = CGAL::AABB_tree<
    CGAL::AABB_traits<mesh::CgalKernel, CGAL::AABB_face_graph_triangle_primitive<TaggedMesh>>>;

constexpr double kHairShare = 0.02;  // of the wrap tolerance

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

bool beyondCutPlane(const mesh::SurfaceMesh& mesh, const CutPlane& plane) {
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    if (plane.normal.dot(mesh.V.row(v).transpose() - plane.point) > 0.0) return false;
  }
  return true;
}

mesh::Vector3 toVector(const mesh::CgalKernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

/// Where the pieces of a body are.
struct Whereabouts {
  std::vector<char> kept;  // #pieces: inside the skin or across it, and not beyond a cut plane
  bool crosses = false;    // some piece meets the skin
  std::int64_t outside = 0;
  mesh::Vector3 place = mesh::Vector3::Zero();  // of the largest outside
  double extent = 0.0;                          // of that [m]
};

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
        box_(mesh::boundingBox(input.skin)),
        size_(4.0 * box_.diagonal()) {}

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

  /// Piece by piece: one outside says nothing about the others.
  [[nodiscard]] Whereabouts whereabouts(const TaggedMesh& mesh, const MeshPieces& pieces,
                                        const Tree& skinTree, const Inside& insideSkin) const {
    Whereabouts out;
    for (const auto& faces : pieces.faces) {
      mesh::Box box;
      bool crosses = false;
      std::vector<char> beyond(input_.cutPlanes.size(), 1);
      for (const auto f : faces) {
        std::array<mesh::CgalKernel::Point_3, 3> corner;
        auto next = corner.begin();
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
          *next = mesh.point(v);
          const mesh::Vector3 p = toVector(*next++);
          box.add(p);
          for (std::size_t k = 0; k < beyond.size(); ++k) {
            const CutPlane& plane = input_.cutPlanes[k];
            if (plane.normal.dot(p - plane.point) > 0.0) beyond[k] = 0;
          }
        }
        crosses = crosses || skinTree.do_intersect(
                                 mesh::CgalKernel::Triangle_3(corner[0], corner[1], corner[2]));
      }
      const bool cutAway = std::ranges::find(beyond, 1) != beyond.end();
      const auto first = mesh.point(mesh.target(mesh.halfedge(faces.front())));
      const bool inside = crosses || insideSkin(first) != CGAL::ON_UNBOUNDED_SIDE;
      out.kept.push_back(inside && !cutAway);
      out.crosses = out.crosses || (crosses && !cutAway);
      if (inside || cutAway) continue;
      ++out.outside;
      if (box.diagonal() <= out.extent) continue;
      out.extent = box.diagonal();
      out.place = box.centre();
    }
    return out;
  }

  /// Leaves out what lies beyond a cut plane or outside the skin, and measures what pokes out.
  Result<void> gatherHoles() {
    const Tree skinTree(skin_.faces().begin(), skin_.faces().end(), skin_);
    const Inside insideSkin(skinTree);
    const auto skinPoints = pointsOfPieces(skin_);
    int boneCount = 0;
    std::vector<const Hole*> outside;  // bones
    for (std::size_t h = 0; h < input_.holes.size(); ++h) {
      const Hole& hole = input_.holes[h];
      if (run_.cancelled()) return fail(ErrorCode::Cancelled, "carving the domain");
      const bool beyond = std::ranges::any_of(input_.cutPlanes, [&](const CutPlane& plane) {
        return beyondCutPlane(hole.mesh, plane);
      });
      const bool bone = hole.tag.kind == BoundaryTag::Kind::Bone;
      boneCount += bone;
      if (beyond) {
        out_.leftOut.push_back(h);
        continue;
      }
      auto gathered = bodyOf(hole, options_.wrapTolerance, run_);
      if (!gathered) return passOn(gathered);
      const TaggedMesh& mesh = gathered->mesh;
      const MeshPieces pieces = piecesOf(mesh);
      Whereabouts where = whereabouts(mesh, pieces, skinTree, insideSkin);
      if (where.outside > 0) {
        // Around the skin is not outside it
        const Inside insideBody(mesh);
        const auto held = std::ranges::count_if(
            skinPoints, [&](const auto& p) { return insideBody(p) == CGAL::ON_BOUNDED_SIDE; });
        if (held == std::ssize(skinPoints) && !where.crosses) {
          return fail(ErrorCode::EmptyDomain,
                      fmt::format("\"{}\" encloses the whole skin, so nothing is left of it; check "
                                  "the units and the frame of both",
                                  hole.name),
                      {.object = hole.name, .point = anyPoint(mesh)});
        }
        if (held > 0) {
          std::ranges::fill(where.kept, 1);
          where.outside = 0;
        }
      }
      if (where.outside > 0) noteOutside(hole, where);
      if (std::ranges::find(where.kept, 1) == where.kept.end()) {
        if (bone && where.outside > 0) outside.push_back(&hole);
        out_.leftOut.push_back(h);
        continue;
      }
      if (std::ranges::find(where.kept, 0) != where.kept.end())
        gathered->mesh = keepPieces(std::move(gathered->mesh), pieces, where.kept);
      if (where.crosses) reportPokingOut(hole, mesh);
      bodies_.push_back(std::move(*gathered));
    }
    if (boneCount > 0 && std::ssize(outside) == boneCount) {
      const bool hollow = std::ranges::any_of(mesh::checkSurface(input_.skin).components,
                                              &mesh::SurfaceCheck::Component::inward);
      return fail(
          ErrorCode::BonesOutsideSkin,
          fmt::format("{} outside the skin; {}",
                      boneCount == 1
                          ? fmt::format("the only bone, \"{}\", lies", outside.back()->name)
                          : fmt::format("all {} bones lie", boneCount),
                      hollow ? "it is hollow, an inner layer faces inward: ask for \"repair\": "
                               "\"outer-hull\" at the skin"
                             : "check the units and the frame of skin and bones"),
          {.object = input_.skin.name, .point = outside.back()->mesh.V.row(0).transpose()});
    }
    return {};
  }

  void noteOutside(const Hole& hole, const Whereabouts& where) {
    const bool all = where.outside == std::ssize(where.kept);
    note(
        Severity::Warning, "outside-skin", hole.name,
        all ? fmt::format("\"{}\" lies outside the skin and was left out", hole.name)
            : fmt::format("{} of {} pieces of \"{}\" lie outside the skin and were left out, up to "
                          "{:.3g} m across",
                          where.outside, where.kept.size(), hole.name, where.extent),
        where.place, all ? 0.0 : where.extent);
  }

  /// What of the body is neither in the skin nor beyond a cut plane; nothing where the exact way is
  /// barred.
  [[nodiscard]] std::optional<TaggedMesh> outsideOf(const TaggedMesh& body) const {
    TaggedMesh out = body;
    if (!combine(out, skin_, Operation::Difference)) return std::nullopt;
    for (const CutPlane& plane : input_.cutPlanes) {
      if (out.number_of_faces() == 0) break;
      const auto p = PMP::bbox(out);
      mesh::Box around = box_;
      around.add(mesh::Vector3(p.xmin(), p.ymin(), p.zmin()));
      around.add(mesh::Vector3(p.xmax(), p.ymax(), p.zmax()));
      if (!combine(out, halfSpace(plane, 0, around), Operation::Intersection)) return std::nullopt;
    }
    return out;
  }

  void reportPokingOut(const Hole& hole, const TaggedMesh& mesh) {
    const double whole = CGAL::to_double(PMP::volume(mesh));
    const auto tell = [&](double volume, const char* about, const mesh::Vector3& place) {
      note(
          Severity::Repaired, "pokes-out", hole.name,
          fmt::format("\"{}\" reaches out of the skin with {}{:.3g} cm³ of its {:.3g} cm³; cut off "
                      "there",
                      hole.name, about, volume * 1e6, whole * 1e6),
          place, volume);
    };
    if (const auto outside = outsideOf(mesh)) {
      const double volume = CGAL::to_double(PMP::volume(*outside));
      if (volume > 0.0 && outside->number_of_vertices() > 0) tell(volume, "", anyPoint(*outside));
      return;
    }
    // Walls that touch in edges or corners bar the exact way: points of a lattice are counted
    TaggedMesh copy = mesh;
    const TaggedSurface body = fromCgal(copy);
    const mesh::SurfaceMesh plain{.name = hole.name, .V = body.V, .F = body.F};
    const auto out = mesh::pokingOut(
        mesh::ContactBody(plain), mesh::ContactBody(input_.skin), [&](const mesh::Vector3& p) {
          return std::ranges::all_of(input_.cutPlanes, [&](const CutPlane& plane) {
            return plane.normal.dot(p - plane.point) > 0.0;
          });
        });
    if (out) tell(out->volume, "about ", out->place);
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
        if (combine(skin_, halfSpace(plane, tag, box_), Operation::Intersection)) {
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

  /// Tells what became of the holes in there.
  void noteBody(const Body& body) {
    const std::string& first = body.holes.front()->name;
    if (body.holes.size() > 1) {
      const std::string how =
          body.grown.empty()
              ? std::string()
              : fmt::format("; for that {} grown by {:.2g} mm",
                            namesOf(body.grown) + (body.grown.size() == 1 ? " was" : " were"),
                            growth(options_.wrapTolerance) * 1e3);
      note(body.grown.empty() ? Severity::Note : Severity::Repaired, "united", first,
           fmt::format("{} touch or overlap and were united{}", namesOf(body.holes), how),
           anyPoint(body.mesh), static_cast<double>(body.holes.size()));
    }
    if (!body.wrapped.empty()) noteWrap(body.wrapped, body.mesh);
  }

  void noteWrap(const std::vector<const Hole*>& holes, const TaggedMesh& mesh) {
    ++out_.wrapCount;
    for (const Hole* hole : holes)
      out_.wrapped.push_back(static_cast<std::size_t>(hole - input_.holes.data()));
    note(Severity::Repaired, "wrapped", holes.front()->name,
         fmt::format("{} had to be wrapped (open, self-intersecting or touching); the wrap strays "
                     "by at most {:.3g} mm",
                     namesOf(holes), options_.wrapTolerance * 1e3),
         anyPoint(mesh), options_.wrapTolerance);
  }

  Result<void> takeHolesOut() {
    if (bodies_.empty()) return {};
    auto bodies = unitedBodies(std::move(bodies_), options_.wrapTolerance, run_);
    if (!bodies) return passOn(bodies);
    for (const Body& body : *bodies) noteBody(body);
    return takeOut(*bodies);
  }

  /// All at once. Where something in there defeats the exact way, one half and then the other, down
  /// to the culprits, which are wrapped.
  Result<void> takeOut(std::span<const Body> bodies) {
    if (run_.cancelled()) return fail(ErrorCode::Cancelled, "carving the domain");
    TaggedMesh all = bodies.front().mesh;
    for (const Body& body : bodies.subspan(1)) all += body.mesh;
    if (combine(skin_, all, Operation::Difference)) return {};
    if (bodies.size() > 1) {
      const std::size_t half = bodies.size() / 2;
      if (auto first = takeOut(bodies.first(half)); !first) return first;
      return takeOut(bodies.subspan(half));
    }
    const Body& body = bodies.front();
    auto wrapped = wrapBody(body.holes, options_.wrapTolerance, run_);
    if (!wrapped) return passOn(wrapped);
    noteWrap(body.holes, wrapped->mesh);
    if (combine(skin_, wrapped->mesh, Operation::Difference)) return {};
    return fail(ErrorCode::MeshNotRepairable,
                fmt::format("{} cannot be taken out of the skin", namesOf(body.holes)),
                {.object = body.holes.front()->name, .point = anyPoint(wrapped->mesh)});
  }

  const CarveInput& input_;
  const CarveOptions& options_;
  RunContext& run_;
  mesh::Box box_;  // of the skin
  double size_;
  TaggedMesh skin_;
  std::vector<Body> bodies_;
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
