#include <ecorche/authoring/snap.h>
#include <ecorche/mesh/surface_check.h>

#include <algorithm>

namespace ecorche::authoring {

using mesh::Vector3;
using model::Support;

namespace {

void keepNearer(std::optional<Snap>& best, double reach, const Support& support, const Vector3& at,
                const Vector3& p) {
  const double distance = (at - p).norm();
  if (distance <= reach && (!best || distance < best->distance)) best = Snap{support, at, distance};
}

}  // namespace

BoneSurface boneSurface(std::string name, const mesh::SurfaceMesh& mesh) {
  const mesh::SurfaceCheck check = mesh::checkSurface(mesh);
  BoneSurface out{std::move(name), mesh::boundingBox(mesh),
                  std::make_shared<mesh::SurfaceQuery>(mesh), nullptr};
  // Winding numbers bear edges with four faces, but no sheets inside, whose edges have three, and
  // doubled faces may cancel each other
  const bool closed = !check.components.empty() &&
                      std::ranges::all_of(check.components, &mesh::SurfaceCheck::Component::closed);
  if (closed && check.inconsistentEdges == 0 && check.duplicateFaces == 0) out.solid = out.surface;
  return out;
}

SnapTargets snapTargets(const model::Project& project, std::vector<BoneSurface> bones) {
  SnapTargets out{std::move(bones), project.cutPlanes, {}};
  for (const model::Tissue& tissue : project.tissues) {
    for (const model::Curve& curve : tissue.curves)
      out.curves.push_back({tissue.name, splineOf(curve)});
  }
  return out;
}

std::optional<Snap> snapToBone(const Vector3& p, const std::vector<BoneSurface>& bones,
                               double reach) {
  std::optional<Snap> best;
  for (const BoneSurface& bone : bones) {
    const double limit = best ? best->distance : reach;
    if (bone.surface->empty() || bone.distanceToBox(p) > limit) continue;
    keepNearer(best, reach, {Support::On::Bone, bone.name}, bone.surface->closest(p).point, p);
  }
  return best;
}

std::optional<Snap> snapEnd(const Vector3& p, const SnapTargets& targets, double reach,
                            const std::string& owner) {
  std::optional<Snap> best = snapToBone(p, targets.bones, reach);
  for (const model::CutPlane& plane : targets.planes) {
    const Vector3 foot = p - (p - plane.point).dot(plane.normal) * plane.normal;
    keepNearer(best, reach, {Support::On::Plane, plane.name}, foot, p);
  }
  for (const SnapTargets::TissueCurve& curve : targets.curves) {
    if (curve.tissue == owner) continue;
    keepNearer(best, reach, {Support::On::Tissue, curve.tissue},
               curve.spline.at(curve.spline.nearest(p)), p);
  }
  return best;
}

}  // namespace ecorche::authoring
