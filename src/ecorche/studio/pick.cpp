#include <ecorche/engine/live_parts.h>
#include <ecorche/render/ray_caster.h>
#include <ecorche/studio/pick.h>
#include <ecorche/studio/volume_look.h>

#include <algorithm>
#include <limits>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

bool clippedAway(const Vector3& p, const Display& display) {
  return display.clip && (p - display.clip->point).dot(display.clip->normal) < 0.0;
}

bool cutOff(const Vector3& p, const model::Project& project) {
  return std::ranges::any_of(project.cutPlanes, [&](const model::CutPlane& plane) {
    return (p - plane.point).dot(plane.normal) < 0.0;
  });
}

}  // namespace

std::optional<BoneHit> boneUnder(const authoring::SightRay& sight, const engine::LiveMeshes& meshes,
                                 const model::Project& project, const Display& display) {
  std::optional<BoneHit> best;
  for (const authoring::BoneSurface& bone : meshes.bones) {
    if (!display.showsBone(bone.name)) continue;
    if (!display.clip && project.cutPlanes.empty()) {
      const auto hit = bone.surface->firstHit(sight.origin, sight.direction);
      if (hit && (!best || hit->t < best->distance)) best = BoneHit{bone.name, hit->point, hit->t};
      continue;
    }
    for (const auto& hit : bone.surface->allHits(sight.origin, sight.direction)) {
      if (clippedAway(hit.point, display) || cutOff(hit.point, project)) continue;
      if (!best || hit.t < best->distance) best = BoneHit{bone.name, hit.point, hit.t};
      break;
    }
  }
  return best;
}

std::optional<Selection> Picker::pickHandle(const Input& input, const Eigen::Vector2d& pixel) {
  const auto place = model::findTissue(input.project, input.selection.tissue);
  if (!place) return std::nullopt;
  const model::Tissue& tissue = input.project.tissues[*place];
  std::optional<Selection> best;
  double nearest = kHandReach;
  for (std::size_t c = 0; c < tissue.curves.size(); ++c) {
    for (std::size_t p = 0; p < tissue.curves[c].points.size(); ++p) {
      const auto seen = input.camera.pixelOf(tissue.curves[c].points[p].at);
      if (!seen || (*seen - pixel).norm() > nearest) continue;
      nearest = (*seen - pixel).norm();
      best = Selection{tissue.name, static_cast<int>(c), static_cast<int>(p), {}};
    }
  }
  if (best) return best;
  for (std::size_t c = 0; c < tissue.curves.size(); ++c) {
    const mesh::Spline spline = model::splineOf(tissue.curves[c]);
    const double length = spline.length();
    for (int k = 0; k <= 60; ++k) {
      const auto seen = input.camera.pixelOf(spline.at(spline.parameterAt(length * k / 60.0)));
      if (!seen || (*seen - pixel).norm() > nearest) continue;
      nearest = (*seen - pixel).norm();
      best = Selection{tissue.name, static_cast<int>(c), -1, {}};
    }
  }
  return best;
}

Selection Picker::pick(const Input& input, const Eigen::Vector2d& pixel) {
  if (const auto handle = pickHandle(input, pixel)) return *handle;
  const authoring::SightRay sight = input.camera.sight(pixel);
  double nearest = std::numeric_limits<double>::infinity();
  Selection out;
  if (input.tissues) {
    const render::VolumeItem volume = volumeOf(input.project, *input.tissues, input.display, {});
    const auto hit = render::castRay({sight.origin, sight.direction}, volume, input.display.clip);
    const auto places = engine::liveTissuePlaces(input.project);
    if (hit && hit->tissue.value >= kFirstMuscle.value) {
      const auto i = static_cast<std::size_t>(hit->tissue.value - kFirstMuscle.value);
      if (input.tissues->slotOf[i] < places.size()) {
        nearest = hit->distance;
        out = Selection{input.project.tissues[places[input.tissues->slotOf[i]]].name, -1, -1, {}};
      }
    }
  }
  if (input.meshes) {
    const auto bone = boneUnder(sight, *input.meshes, input.project, input.display);
    if (bone && bone->distance < nearest) out = Selection{{}, -1, -1, bone->bone};
  }
  return out;
}

}  // namespace ecorche::studio
