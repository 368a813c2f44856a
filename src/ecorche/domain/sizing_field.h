#pragma once

#include <ecorche/core/byte_stream.h>
#include <ecorche/domain/tagged_surface.h>

#include <vector>

namespace ecorche::domain {

/// A place and the edge length wanted around it, before everything is scaled to the tet budget.
struct WantedLength {
  mesh::Vector3 point = mesh::Vector3::Zero();  ///< [m]
  double length = 0.0;                          ///< [m, > 0]
};

/// Wanted edge length for every point of the domain's box: on a grid, continuous between its
/// points, and growing no faster than the gradation.
class SizingField {
 public:
  SizingField() = default;  ///< of an empty box: no length at all, anywhere
  /// @param coarsest   nowhere longer than this [m]
  /// @param gradation  how fast lengths grow with distance [unitless, >= 0]
  SizingField(const mesh::Box& box, const std::vector<WantedLength>& sources, double coarsest,
              double gradation);

  [[nodiscard]] double at(const mesh::Vector3& p) const;  ///< [m]
  [[nodiscard]] const mesh::Box& box() const { return box_; }

  void write(ByteWriter& out) const;
  /// Any bytes are safe to read; where they are no field, `in` is not ok() any more.
  [[nodiscard]] static SizingField read(ByteReader& in);

 private:
  mesh::Box box_;
  Eigen::Array3i count_ = Eigen::Array3i::Zero();
  double cell_ = 1.0;
  std::vector<double> value_;

  [[nodiscard]] std::size_t slot(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * static_cast<std::size_t>(count_.y()) +
            static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(count_.x()) +
           static_cast<std::size_t>(x);
  }
  void spread(double gradation);
};

/// Small tets between walls that are near each other.
/// @param finest    no length below this [m]
/// @param coarsest  gaps that want a longer one are none [m]
[[nodiscard]] std::vector<WantedLength> lengthsInGaps(const TaggedSurface& walls, double finest,
                                                      double coarsest);

}  // namespace ecorche::domain
