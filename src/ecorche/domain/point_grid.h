#pragma once

#include <ecorche/mesh/types.h>

#include <vector>

namespace ecorche::domain {

/// Points that each claim a ball around themselves, found by place. Radii may differ widely over
/// the box but little from one neighbour to the next: hashed cells of one size per power of two of
/// the radius.
class PointGrid {
 public:
  explicit PointGrid(std::size_t expected);

  void add(const mesh::Vector3& p, double radius);
  /// True where some point q with radius s is nearer to p than half the sum of radius and s.
  [[nodiscard]] bool taken(const mesh::Vector3& p, double radius) const;
  [[nodiscard]] std::size_t size() const { return points_.size(); }

 private:
  struct Point {
    mesh::Vector3 place;
    double radius;
    std::int32_t next;  // in the same cell; -1: last
  };
  struct Cell {
    std::int64_t key = -1;
    std::int32_t first = -1;
  };
  static int levelOf(double radius);
  [[nodiscard]] static std::int64_t keyOf(int level, std::int64_t x, std::int64_t y,
                                          std::int64_t z);
  [[nodiscard]] std::size_t slotOf(std::int64_t key) const;
  void grow();

  std::vector<Point> points_;
  std::vector<Cell> cells_;  // open addressing, a power of two
  std::size_t used_ = 0;
};

}  // namespace ecorche::domain
