#pragma once

#include <ecorche/authoring/snap.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/model/project.h>

#include <limits>
#include <vector>

namespace ecorche::authoring {

/// Where muscles may run: inside the skin and out of bones. Keeps references; safe from many
/// threads.
class FreeSpace {
 public:
  /// @param skin   closed
  /// @param bones  those without a solid count with their surface alone: near it is near on both
  /// sides
  FreeSpace(const mesh::SurfaceQuery& skin, const std::vector<BoneSurface>& bones)
      : FreeSpace(&skin, bones) {}
  /// @param skin  closed; null where there is none: bones are all that is in the way
  FreeSpace(const mesh::SurfaceQuery* skin, const std::vector<BoneSurface>& bones)
      : skin_(skin), bones_(bones) {}

  /// Distance to the nearest wall, negative within bone and outside the skin [m].
  /// @param reach  walls farther than this are not looked for: the answer is at most this [m]
  /// @param own    place of a bone that does not count; -1: all count
  [[nodiscard]] double room(const mesh::Vector3& x, double reach, int own = -1) const;

  /// The step that takes x at least `clearance` away from walls; between skin and bone that are
  /// nearer to one another than that it leads to the middle. Zero where x is well placed.
  struct Push {
    mesh::Vector3 step = mesh::Vector3::Zero();             // [m]
    double room = std::numeric_limits<double>::infinity();  ///< as `room`, within reach
  };
  [[nodiscard]] Push push(const mesh::Vector3& x, double clearance, double reach) const;

 private:
  const mesh::SurfaceQuery* skin_;
  const std::vector<BoneSurface>& bones_;

  [[nodiscard]] bool hasSkin() const { return skin_ && !skin_->empty(); }
  template <class Act>
  void eachBone(const mesh::Vector3& x, double reach, int own, const Act& act) const;
};

}  // namespace ecorche::authoring
