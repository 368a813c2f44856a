#pragma once

#include <ecorche/mesh/types.h>

#include <Eigen/Core>
#include <vector>

namespace ecorche::render {

/// What shadow maps must cover: the surfaces that the picture shows, as a ball and a set of points.
struct ShadowFocus {
  std::vector<Eigen::Vector3f> points;
  Eigen::Vector3f lo = Eigen::Vector3f::Zero();
  Eigen::Vector3f hi = Eigen::Vector3f::Zero();

  /// Widest extent of a map [m].
  [[nodiscard]] double diameter() const { return static_cast<double>((hi - lo).norm()) * 1.04; }
  /// Extent of a map along the light [m].
  [[nodiscard]] double depth() const { return diameter(); }
};

/// @param corners  of triangles, three after another
/// @param worldToClip  of the eye
/// @return  corners of all triangles that may show in the picture (all, where none does), thinned
/// out to some thousands
[[nodiscard]] ShadowFocus shadowFocus(const std::vector<Eigen::Vector3f>& corners,
                                      const Eigen::Matrix4f& worldToClip);

/// Parallel projection from a lamp, square, no wider than the focus needs.
struct ShadowMap {
  Eigen::Matrix4f worldToClip;
  Eigen::Matrix4f worldToTexture;  ///< to [0, 1]³
};
[[nodiscard]] ShadowMap shadowMap(const ShadowFocus& focus, const mesh::Vector3& towardsLight,
                                  int size);

}  // namespace ecorche::render
