#include <ecorche/authoring/names.h>
#include <ecorche/authoring/snap.h>
#include <ecorche/authoring/symmetry.h>
#include <ecorche/studio/twins.h>

#include <algorithm>
#include <limits>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

constexpr double kReachRel = 0.02;  // of an end, to the bone that it sits on [of the diagonal]

// Of mirrored frames e2 changes sides (tissue/anisotropy.h), so the angle does, too
model::Anisotropy image(model::Anisotropy a) {
  a.rotation = -a.rotation;
  return a;
}

std::vector<model::Curve> imagesOf(const model::Project& project, const engine::LiveMeshes* meshes,
                                   const model::Tissue& tissue, const MirrorPlane& plane) {
  const double reach = meshes != nullptr ? kReachRel * meshes->diagonal : 0.0;
  std::vector<model::Curve> curves = tissue.curves;
  for (model::Curve& curve : curves) {
    for (auto& p : curve.points) p.at = plane.image(p.at);
    const auto carry = [&](model::Support& support, Vector3& end) {
      if (support.on == model::Support::On::Plane) return;
      if (support.on == model::Support::On::Bone) {
        const auto other = authoring::mirroredName(support.name);
        if (other && model::findBone(project, *other)) support.name = *other;
      }
      if (support.on != model::Support::On::Tissue && meshes != nullptr) {
        const auto snap = authoring::snapToBone(end, meshes->bones, reach);
        support = snap ? snap->support : model::Support{};
        if (snap) end = snap->at;
      } else if (support.on == model::Support::On::Tissue) {
        const auto other = authoring::mirroredName(support.name);
        if (other && model::findTissue(project, *other)) support.name = *other;
      }
    };
    carry(curve.start, curve.points.front().at);
    carry(curve.end, curve.points.back().at);
  }
  return curves;
}

// Heads that came or went change all of them; else each by itself
void renewCurves(const std::vector<model::Curve>& wanted, const model::Tissue& twin,
                 std::vector<model::Command>& out) {
  if (wanted.size() != twin.curves.size()) {
    for (std::size_t c = 0; c < twin.curves.size(); ++c)
      out.push_back(model::RemoveCurve{twin.name, 0});
    for (const model::Curve& curve : wanted) out.push_back(model::AddCurve{twin.name, curve});
    return;
  }
  for (std::size_t c = 0; c < wanted.size(); ++c) {
    const model::Curve& now = twin.curves[c];
    if (wanted[c].points != now.points)
      out.push_back(model::SetCurvePoints{twin.name, c, wanted[c].points});
    if (wanted[c].start != now.start)
      out.push_back(model::SetCurveStart{twin.name, c, wanted[c].start});
    if (wanted[c].end != now.end) out.push_back(model::SetCurveEnd{twin.name, c, wanted[c].end});
    if (wanted[c].name != now.name) out.push_back(model::RenameCurve{twin.name, c, wanted[c].name});
  }
}

const model::Tissue* tissueOf(const model::Project& project, const std::string& name) {
  const auto place = model::findTissue(project, name);
  return place ? &project.tissues[*place] : nullptr;
}

// What its image depends on
bool sameBody(const model::Tissue& a, const model::Tissue& b) {
  return a.curves == b.curves && a.colour == b.colour && a.group == b.group && a.layer == b.layer &&
         a.coreRadius == b.coreRadius && a.anisotropy == b.anisotropy;
}

}  // namespace

std::optional<MirrorPlane> symmetryPlane(const model::Project& project) {
  for (const model::CutPlane& plane : project.cutPlanes) {
    if (plane.kind == model::CutPlane::Kind::Symmetry)
      return MirrorPlane{plane.point, plane.normal};
  }
  return std::nullopt;
}

std::optional<MirrorPlane> mirrorPlane(const mesh::SurfaceMesh& skin) {
  if (skin.F.rows() == 0) return std::nullopt;
  RunContext run;
  const auto found = authoring::findSymmetryPlane(skin, {}, run);
  if (found && *found) return MirrorPlane{(*found)->point, (*found)->normal};
  const mesh::Box box = mesh::boundingBox(skin);
  const mesh::SurfaceQuery surface(skin);
  MirrorPlane best;
  double least = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const MirrorPlane plane{box.centre(), Vector3::Unit(axis)};
    double sum = 0.0;
    const Eigen::Index step = std::max<Eigen::Index>(1, skin.V.rows() / 400);
    for (Eigen::Index v = 0; v < skin.V.rows(); v += step)
      sum += surface.distance(plane.image(skin.V.row(v).transpose()));
    if (sum < least) {
      least = sum;
      best = plane;
    }
  }
  return best;
}

std::vector<model::Command> imageOf(const model::Project& project, const engine::LiveMeshes* meshes,
                                    const model::Tissue& tissue, const std::string& twin,
                                    const MirrorPlane& plane) {
  const std::vector<model::Curve> curves = imagesOf(project, meshes, tissue, plane);
  std::vector<model::Command> out;
  model::Tissue none{.name = twin, .kind = tissue.kind};
  const model::Tissue* there = tissueOf(project, twin);
  if (there == nullptr) {
    if (tissue.kind == model::Tissue::Kind::Filler) {
      out.push_back(model::AddFiller{twin});
    } else {
      out.push_back(model::AddMuscle{twin});
    }
    const model::Side side = authoring::sideFrom(twin);
    if (side != model::Side::Unknown) out.push_back(model::SetSide{twin, side});
    there = &none;
  }
  renewCurves(curves, *there, out);
  if (tissue.colour != there->colour) out.push_back(model::SetColour{twin, tissue.colour});
  if (tissue.group != there->group) out.push_back(model::SetGroup{twin, tissue.group});
  if (tissue.layer != there->layer) out.push_back(model::SetLayer{twin, tissue.layer});
  if (tissue.coreRadius != there->coreRadius)
    out.push_back(model::SetTissueCore{twin, tissue.coreRadius});
  if (image(tissue.anisotropy) != there->anisotropy)
    out.push_back(model::SetAnisotropy{twin, image(tissue.anisotropy)});
  if (tissue.keepsTwin != there->keepsTwin)
    out.push_back(model::SetKeepsTwin{twin, tissue.keepsTwin});
  return out;
}

std::optional<model::RenameTissue> twinsRename(const model::Project& before,
                                               const model::RenameTissue& rename) {
  const model::Tissue* tissue = tissueOf(before, rename.tissue);
  const auto from = authoring::mirroredName(rename.tissue);
  const auto to = authoring::mirroredName(rename.name);
  if (tissue == nullptr || !tissue->keepsTwin || !from || !to) return std::nullopt;
  if (tissueOf(before, *from) == nullptr || tissueOf(before, *to) != nullptr) return std::nullopt;
  return model::RenameTissue{*from, *to};
}

std::vector<model::Command> twinsFollow(const model::Project& before, const model::Project& after,
                                        const engine::LiveMeshes* meshes,
                                        const MirrorPlane& plane) {
  std::vector<model::Command> out;
  for (const model::Tissue& tissue : after.tissues) {
    if (!tissue.keepsTwin || tissue.curves.empty()) continue;
    const auto twin = authoring::mirroredName(tissue.name);
    if (!twin) continue;
    const model::Tissue* was = tissueOf(before, tissue.name);
    if (was != nullptr && was->keepsTwin && sameBody(*was, tissue)) continue;
    // Whoever changed both meant both
    const model::Tissue* twinWas = tissueOf(before, *twin);
    const model::Tissue* twinIs = tissueOf(after, *twin);
    if (twinIs != nullptr && (twinWas == nullptr || !sameBody(*twinWas, *twinIs))) continue;
    const auto follow = imageOf(after, meshes, tissue, *twin, plane);
    out.insert(out.end(), follow.begin(), follow.end());
  }
  return out;
}

}  // namespace ecorche::studio
