#pragma once

#include <ecorche/engine/live_engine.h>
#include <ecorche/studio/display.h>
#include <ecorche/studio/orbit_camera.h>

#include <memory>
#include <optional>
#include <string>

namespace ecorche::studio {

/// A bone under a line of sight.
struct BoneHit {
  std::string bone;
  mesh::Vector3 at = mesh::Vector3::Zero();  ///< on its surface [m]
  double distance = 0.0;                     ///< from the ray's origin [m]
};
/// The nearest of the bones that are shown, through whatever lies before it. What lies beyond the
/// project's cut planes, or is taken away by the view's, does not count.
[[nodiscard]] std::optional<BoneHit> boneUnder(const authoring::SightRay& sight,
                                               const engine::LiveMeshes& meshes,
                                               const model::Project& project,
                                               const Display& display);

/// What the hand would take hold of at a pixel: a control point of the selected muscle before its
/// curve, that before the muscle or bone that is seen there.
class Picker {
 public:
  struct Input {
    const model::Project& project;
    const OrbitCamera& camera;
    std::shared_ptr<const engine::LiveMeshes> meshes;
    std::shared_ptr<const engine::LiveTissues> tissues;
    const Display& display;
    const Selection& selection;
  };
  [[nodiscard]] static Selection pick(const Input& input, const Eigen::Vector2d& pixel);
  /// Points and curves of the selected muscle alone: quick enough for every movement of the hand.
  [[nodiscard]] static std::optional<Selection> pickHandle(const Input& input,
                                                           const Eigen::Vector2d& pixel);
};

}  // namespace ecorche::studio
