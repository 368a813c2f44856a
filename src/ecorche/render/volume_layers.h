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

/// Fields averaged over the neighbours of every vertex: what surfaces are shaded by, so that the
/// tets do not show.
class SmoothedFields {
 public:
  /// @param change  null: anything
  void update(const VolumeGeometry& geometry, const tissue::FieldMatrix& fields,
              const FieldChange* change);
  [[nodiscard]] const float* row(std::int32_t vertex) const {
    return values_.data() + static_cast<std::ptrdiff_t>(vertex) * columns_;
  }

 private:
  std::vector<float> values_;
  std::ptrdiff_t columns_ = 0;
};

/// Direction in which tissue column `inside` ends and `outside` begins at a vertex: downhill of the
/// smoothed f_inside − f_outside, averaged over the tets around. Unit; zero where nothing changes.
[[nodiscard]] Eigen::Vector3f interfaceNormal(const VolumeGeometry& geometry,
                                              const SmoothedFields& fields, std::int32_t vertex,
                                              Eigen::Index inside, Eigen::Index outside);
/// The same where nothing has been smoothed yet.
[[nodiscard]] Eigen::Vector3f interfaceNormal(const VolumeGeometry& geometry,
                                              const tissue::FieldMatrix& fields,
                                              std::int32_t vertex, Eigen::Index inside,
                                              Eigen::Index outside);

/// Vertices within so many edges of the given ones, each once.
[[nodiscard]] std::vector<std::int32_t> withNeighbours(const VolumeGeometry& geometry,
                                                       const std::vector<std::int32_t>& vertices,
                                                       int rounds);

/// A smooth normal is not used where it looks away from the true surface: the cosine below which it
/// does.
inline constexpr float kSmoothNormalTrust = -0.1f;

}  // namespace ecorche::render
