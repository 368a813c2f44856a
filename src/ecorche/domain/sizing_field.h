#pragma once

#include <ecorche/core/byte_stream.h>
#include <ecorche/domain/build_domain.h>
#include <ecorche/domain/tagged_surface.h>

#include <vector>

namespace ecorche::domain {

/// Wanted edge length for every point of the domain's box: on a grid, continuous between its
/// points, and growing no faster than the gradation.
class SizingField {
 public:
  /// A place and the length wanted around it.
  struct Source {
    mesh::Vector3 point = mesh::Vector3::Zero();  // [m]
    double length = 0.0;                          ///< [m]
  };

  SizingField() = default;  ///< of an empty box: no length at all, anywhere
  /// @param coarsest   nowhere longer than this [m]
  /// @param gradation  how fast lengths grow with distance [unitless, >= 0]
  SizingField(const mesh::Box& box, const std::vector<Source>& sources, double coarsest,
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

/// What asks for small tets: curves, and gaps between the domain's walls.
[[nodiscard]] std::vector<SizingField::Source> sizingSources(const std::vector<SizingCurve>& curves,
                                                             const TaggedSurface& walls,
                                                             double finest, double coarsest);

}  // namespace ecorche::domain
