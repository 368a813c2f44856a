#include <ecorche/core/parallel.h>
#include <ecorche/domain/prepare_meshes.h>
#include <ecorche/mesh/outer_hull.h>
#include <ecorche/mesh/piece_union.h>
#include <ecorche/mesh/self_intersection.h>
#include <ecorche/mesh/surface_check.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_repair.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/thin_out.h>
#include <ecorche/mesh/uncross.h>
#include <ecorche/mesh/unit_check.h>
#include <ecorche/mesh/winding_above.h>
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

namespace ecorche::domain {

namespace {

using mesh::Vector3;

/// How far the box lies beyond the plane, all of it: negative where some of it is kept.
double beyond(const mesh::Box& box, const CutPlane& plane) {
  const Vector3 half = 0.5 * (box.hi - box.lo);
  const Vector3 n = plane.normal.normalized();
  return -n.dot(box.centre() - plane.point) - n.cwiseAbs().dot(half);
}

bool beyondAPlane(const mesh::SurfaceMesh& mesh, const std::vector<CutPlane>& planes) {
  return std::ranges::any_of(planes, [&](const CutPlane& plane) {
    for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
      if (plane.normal.dot(mesh.V.row(v).transpose() - plane.point) > 0.0) return false;
    }
    return true;
  });
}

double cm3(const mesh::SurfaceMesh& mesh) { return mesh::signedVolume(mesh.V, mesh.F) * 1e6; }

/// Outward pieces that lie within another piece, and a point of the first of them.
struct Nested {
  std::int64_t count = 0;
  Vector3 place = Vector3::Zero();
};
Nested nestedShells(const mesh::SurfaceMesh& mesh, const mesh::SurfaceCheck& check) {
  Nested out;
  if (check.components.size() < 2) return out;
  const mesh::SurfaceQuery query(mesh);
  const double hair = 1e-9 * mesh::boundingBox(mesh).diagonal();
  const auto speaker = mesh::largestFaces(mesh, mesh::components(mesh.F));
  for (std::size_t p = 0; p < check.components.size(); ++p) {
    const auto& piece = check.components[p];
    if (!piece.closed || piece.inward) continue;
    // Just above its faces the surface should not wind around anything
    if (mesh::windingAbove(query, mesh, speaker[p], hair).value_or(0) > 0 && out.count++ == 0)
      out.place = mesh.V.row(mesh.F(speaker[p], 0)).transpose();
  }
  return out;
}

/// Takes a closed surface for what it encloses: shells within it go; where it cuts itself the hull
/// is taken, exactly where that works; otherwise its crossings are smoothed away where that moves
/// nothing further than allowed. What was done, or could not be, is told.
/// @return  whether it is fit for exact subtraction now
bool takeWhatItEncloses(mesh::RepairedSurface& surface, double allowed, RunContext& run) {
  mesh::SurfaceMesh& mesh = surface.mesh;
  const mesh::SurfaceCheck check = mesh::checkSurface(mesh);
  if (!check.isSound()) return false;
  const auto tell = [&](Severity severity, const char* kind, std::string message,
                        const Vector3& place, std::int64_t count) {
    surface.findings.push_back({.severity = severity,
                                .kind = kind,
                                .object = mesh.name,
                                .message = std::move(message),
                                .point = place,
                                .size = static_cast<double>(count)});
  };
  const auto crossings = mesh::selfIntersections(mesh.V, mesh.F);
  if (crossings.empty()) {
    const Nested nested = nestedShells(mesh, check);
    if (nested.count == 0) return true;
    auto hull = mesh::outerHull(mesh, run);
    tell(hull ? Severity::Repaired : Severity::Warning, "inner-shell",
         fmt::format("\"{}\" has {} closed pieces within others; {}", mesh.name, nested.count,
                     hull ? "what is outermost was kept" : "they could not be taken out"),
         nested.place, nested.count);
    if (!hull) return false;
    mesh = std::move(*hull);
    return true;
  }

  const std::string cuts =
      fmt::format("\"{}\" cuts itself in {} pairs of faces; ", mesh.name, crossings.size());
  const Vector3 place = mesh.V.row(mesh.F(crossings.front().first, 0)).transpose();
  const std::int64_t count = std::ssize(crossings);
  auto hull = mesh::outerHull(mesh, run);
  if (!hull) hull = mesh::pieceUnion(mesh, run);
  if (hull) {
    tell(Severity::Repaired, "self-intersections",
         cuts + fmt::format("what it encloses was kept, {:.4g} cm³ of {:.4g} cm³ counted with "
                            "folds",
                            cm3(*hull), cm3(mesh)),
         place, count);
    mesh = std::move(*hull);
    return true;
  }
  if (auto smooth = mesh::uncross(mesh)) {
    const auto apart = mesh::surfaceDeviation(mesh, *smooth, allowed, run);
    if (apart && apart->max() <= allowed) {
      tell(Severity::Repaired, "self-intersections",
           cuts + fmt::format("smoothed there by up to {:.2g} mm", apart->max() * 1e3), place,
           count);
      mesh = std::move(*smooth);
      return true;
    }
  }
  tell(Severity::Warning, "self-intersections",
       cuts +
           "nothing certain could be done about it; \"repair\": \"wrap\" would lay a skin around "
           "it",
       place, count);
  return false;
}

/// A sculpt of millions of triangles is thinned out to what can be told apart, unless that makes it
/// cut itself.
/// @return  how far it was moved [m]
Result<double> thin(mesh::RepairedSurface& surface, double allowed, RunContext& run) {
  constexpr Eigen::Index kDense = 150000;  // faces that resampling takes as they are
  constexpr double kShare = 0.2;           // of what repairs may move
  mesh::SurfaceMesh& mesh = surface.mesh;
  if (mesh.F.rows() <= kDense || !mesh::checkSurface(mesh).isSound()) return 0.0;
  auto thinned = mesh::thinOut(mesh, kShare * allowed, run);
  if (!thinned) return passOn(thinned);
  if (!*thinned) return 0.0;
  const auto& [fewer, deviation] = **thinned;
  if (!mesh::selfIntersections(fewer.V, fewer.F).empty() &&
      mesh::selfIntersections(mesh.V, mesh.F).empty())
    return 0.0;
  surface.findings.push_back(
      {.severity = Severity::Note,
       .kind = "dense",
       .object = mesh.name,
       .message = fmt::format("\"{}\" has {} faces; {} of them say the same within {:.2g} mm, and "
                              "the domain is made from these",
                              mesh.name, mesh.F.rows(), fewer.F.rows(), deviation * 1e3),
       .size = static_cast<double>(mesh.F.rows())});
  const double moved = deviation;
  mesh = std::move((*thinned)->mesh);
  return moved;
}

/// A skin may be open where it is cut away.
Result<mesh::RepairedSurface> repairSkin(const DomainInput& input, RunContext& run) {
  auto closed = mesh::repairSurface(input.skin, {.mustClose = true}, run);
  if (closed || closed.error().code != ErrorCode::SkinNotClosed || input.cutPlanes.empty())
    return closed;
  const auto open = mesh::repairSurface(input.skin, {}, run);
  if (!open) return closed;
  const mesh::SurfaceCheck check = mesh::checkSurface(open->mesh);
  const bool cutAway = std::ranges::all_of(check.holes, [&](const auto& hole) {
    return std::ranges::any_of(input.cutPlanes, [&](const CutPlane& plane) {
      return beyond(hole.box, plane) > 1e-6 * hole.extent;
    });
  });
  if (!cutAway) return closed;
  return mesh::repairSurface(
      input.skin, {.holeRel = std::numeric_limits<double>::infinity(), .mustClose = true}, run);
}

/// Bones that cannot be meant are an error, others a warning.
Result<void> compareUnits(const DomainInput& input, Findings& findings) {
  for (const mesh::UnitMismatch& mismatch : mesh::unitMismatches(input.skin, input.bones)) {
    const mesh::SurfaceMesh& bone = input.bones[mismatch.bone.value_or(0)];
    const Vector3 place = mesh::boundingBox(bone).centre();
    if (mismatch.certain)
      return fail(ErrorCode::UnitsDiffer, mismatch.message, {.object = bone.name, .point = place});
    findings.push_back({.severity = Severity::Warning,
                        .kind = "units",
                        .object = bone.name,
                        .message = mismatch.message,
                        .point = place,
                        .size = mismatch.factor});
  }
  return {};
}

}  // namespace

Result<PreparedMesh> prepareMesh(const mesh::SurfaceMesh& mesh, bool mustClose, double allowed,
                                 RunContext& run) {
  // A bone that is open at one end is capped there; what is open on all sides is a sheet
  constexpr double kSolidHoleRel = 0.5;
  auto repaired = mesh::repairSurface(mesh,
                                      mustClose ? mesh::RepairOptions{.mustClose = true}
                                                : mesh::RepairOptions{.holeRel = kSolidHoleRel},
                                      run);
  if (!repaired) return passOn(repaired);
  PreparedMesh out{.surface = std::move(*repaired)};
  const auto moved = thin(out.surface, allowed, run);
  if (!moved) return passOn(moved);
  out.moved = *moved;
  out.fit = takeWhatItEncloses(out.surface, allowed, run);
  return out;
}

Result<PreparedMeshes> prepareMeshes(const DomainInput& input, double movedRel, RunContext& run) {
  const Stage stage(run, "domain: check and repair");
  PreparedMeshes out;
  if (auto same = compareUnits(input, out.findings); !same) return passOn(same);
  auto skin = repairSkin(input, run);
  if (!skin) return passOn(skin);
  const double allowed = movedRel * mesh::boundingBox(skin->mesh).diagonal();
  const auto skinMoved = thin(*skin, allowed, run);
  if (!skinMoved) return passOn(skinMoved);
  out.carve.skinMoved = *skinMoved;
  // A skin that cannot be mended may still do where the crossing is cut off or resampled away
  takeWhatItEncloses(*skin, allowed, run);
  out.findings.insert(out.findings.end(), skin->findings.begin(), skin->findings.end());
  out.carve.skin = std::move(skin->mesh);
  out.carve.cutPlanes = input.cutPlanes;
  for (CutPlane& plane : out.carve.cutPlanes) plane.normal.normalize();

  struct Wanted {
    const mesh::SurfaceMesh* mesh;
    BoundaryTag tag;
  };
  std::vector<Wanted> wanted;
  const auto add = [&](const std::vector<mesh::SurfaceMesh>& list, BoundaryTag::Kind kind) {
    for (std::size_t i = 0; i < list.size(); ++i)
      wanted.push_back({&list[i], {kind, static_cast<std::int32_t>(i)}});
  };
  add(input.bones, BoundaryTag::Kind::Bone);
  add(input.obstacles, BoundaryTag::Kind::Obstacle);
  add(input.cavities, BoundaryTag::Kind::Cavity);
  std::vector<Result<PreparedMesh>> prepared(wanted.size());
  parallelFor(
      static_cast<std::int64_t>(wanted.size()),
      [&](std::int64_t i) {
        const auto k = static_cast<std::size_t>(i);
        if (beyondAPlane(*wanted[k].mesh, input.cutPlanes)) {
          prepared[k] = PreparedMesh{.surface = {*wanted[k].mesh, {}}};
        } else {
          prepared[k] = prepareMesh(*wanted[k].mesh, false, allowed, run);
        }
      },
      1);
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    if (!prepared[k]) return passOn(prepared[k]);
    auto& [mesh, findings] = prepared[k]->surface;
    out.findings.insert(out.findings.end(), findings.begin(), findings.end());
    out.carve.holes.push_back({wanted[k].mesh->name, std::move(mesh), wanted[k].tag,
                               prepared[k]->fit, prepared[k]->moved});
    out.bones += wanted[k].tag.kind == BoundaryTag::Kind::Bone;
  }
  return out;
}

}  // namespace ecorche::domain
