#pragma once

// Private to render's sources.

#include <ecorche/render/volume_item.h>

#include <cstdint>
#include <vector>

namespace ecorche::render {

/// What a tissue is to a layer.
enum class Role : std::uint8_t {
  Hidden,  ///< the ray goes through
  Cut,     ///< hidden, but shown where the clip plane cuts it
  Seen
};

/// Tissues that are drawn together: those that share a shift, and are opaque or are not. Whatever
/// is not seen in a layer is empty space to it.
struct VolumeLayer {
  mesh::Vector3 shift = mesh::Vector3::Zero();  // [m]
  bool veil = false;                            ///< x-ray: drawn over what is opaque
  std::vector<Role> role;                       ///< by column of the fields

  bool operator==(const VolumeLayer&) const = default;
};

/// Opaque layers first, then veils; within them in the order of their first tissue.
[[nodiscard]] std::vector<VolumeLayer> volumeLayers(const VolumeItem& item);

/// Direction in which tissue column `inside` ends and `outside` begins at a vertex: downhill of
/// f_inside − f_outside, averaged over the tets around. Unit; zero where nothing changes.
[[nodiscard]] Eigen::Vector3f interfaceNormal(const VolumeGeometry& geometry,
                                              const tissue::FieldMatrix& fields,
                                              std::int32_t vertex, Eigen::Index inside,
                                              Eigen::Index outside);

/// A smooth normal is not used where it departs from the true surface by more than about 75°: the
/// cosine of that.
inline constexpr float kSmoothNormalTrust = 0.25f;

}  // namespace ecorche::render
