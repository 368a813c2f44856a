#include <ecorche/authoring/free_space.h>

#include <algorithm>

namespace ecorche::authoring {

using mesh::Vector3;

namespace {

// Signed distance to a wall, and the direction in which it grows.
struct Wall {
  double distance = 0.0;
  Vector3 away = Vector3::Zero();
};
Wall wall(const mesh::SurfaceQuery& surface, const Vector3& x, bool behind) {
  const auto closest = surface.closest(x);
  // On the wall itself there is no telling which way leads off
  if (closest.distance == 0.0) return {};
  const Vector3 off = (x - closest.point) / closest.distance;
  return behind ? Wall{-closest.distance, -off} : Wall{closest.distance, off};
}

}  // namespace

template <class Act>
void FreeSpace::eachBone(const Vector3& x, double reach, int own, const Act& act) const {
  for (std::size_t b = 0; b < bones_.size(); ++b) {
    const BoneSurface& bone = bones_[b];
    if (static_cast<int>(b) == own || bone.surface->empty() || bone.distanceToBox(x) > reach)
      continue;
    const bool within = bone.solid && bone.distanceToBox(x) == 0.0 && bone.solid->inside(x);
    act(wall(bone.solid ? *bone.solid : *bone.surface, x, within));
  }
}

double FreeSpace::room(const Vector3& x, double reach, int own) const {
  double least = reach;
  if (hasSkin()) least = std::min(least, wall(*skin_, x, !skin_->inside(x)).distance);
  eachBone(x, reach, own, [&](const Wall& bone) { least = std::min(least, bone.distance); });
  return least;
}

FreeSpace::Push FreeSpace::push(const Vector3& x, double clearance, double reach) const {
  // Skin and bones each push by themselves, so that between them x ends in the middle; bones side
  // by side push once, or they would push out of the skin where there is little room
  const Wall skin = hasSkin() ? wall(*skin_, x, !skin_->inside(x)) : Wall{reach};
  Push out{std::max(0.0, clearance - skin.distance) * skin.away, std::min(reach, skin.distance)};
  Vector3 fromBones = Vector3::Zero();
  eachBone(x, reach, -1, [&](const Wall& bone) {
    out.room = std::min(out.room, bone.distance);
    if (bone.distance >= clearance) return;
    fromBones += std::max(0.0, clearance - bone.distance - fromBones.dot(bone.away)) * bone.away;
  });
  const bool between = !out.step.isZero(0.0) && !fromBones.isZero(0.0);
  out.step = (between ? 0.5 : 1.0) * (out.step + fromBones);
  return out;
}

}  // namespace ecorche::authoring
