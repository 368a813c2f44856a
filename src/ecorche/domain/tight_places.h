#pragma once

#include <ecorche/domain/point_grid.h>
#include <ecorche/domain/tagged_surface.h>

#include <functional>
#include <vector>

namespace ecorche::domain {

/// Where walls are so near to each other that resampling may make them cross.
class TightPlaces {
 public:
  /// @param reach  by place: how far around what is added is tight too [m, > 0]
  explicit TightPlaces(std::function<double(const mesh::Vector3&)> reach);

  void add(const mesh::Vector3& p);
  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] bool contains(const mesh::Vector3& p) const;

 private:
  std::function<double(const mesh::Vector3&)> reach_;
  PointGrid thinned_;  // so that a point is kept once where many lie together
  PointGrid points_;
};

/// Middles of the faces straight above or below which another wall is nearer than `gap` [m].
[[nodiscard]] std::vector<mesh::Vector3> placesInGaps(const TaggedSurface& walls, double gap);

}  // namespace ecorche::domain
