#include <ecorche/domain/point_grid.h>

#include <bit>
#include <cmath>

namespace ecorche::domain {

using mesh::Vector3;

PointGrid::PointGrid(std::size_t expected) {
  points_.reserve(expected);
  cells_.resize(std::bit_ceil(std::max<std::size_t>(64, 2 * expected)));
}

// Cells of level n have side 2^n, at least the radius of the points in them
int PointGrid::levelOf(double radius) {
  int exponent = 0;
  std::frexp(radius, &exponent);
  return exponent;
}

std::int64_t PointGrid::keyOf(int level, std::int64_t x, std::int64_t y, std::int64_t z) {
  // 19 bits for each coordinate, 6 for the level; a collision only lengthens a list
  constexpr std::int64_t kMask = (std::int64_t{1} << 19) - 1;
  return ((((static_cast<std::int64_t>(level) & 63) << 19 | (x & kMask)) << 19 | (y & kMask))
              << 19 |
          (z & kMask)) &
         0x7fffffffffffffff;
}

std::size_t PointGrid::slotOf(std::int64_t key) const {
  auto hash = static_cast<std::uint64_t>(key) * 0x9E3779B97F4A7C15ull;
  hash ^= hash >> 32;
  std::size_t slot = hash & (cells_.size() - 1);
  while (cells_[slot].key != key && cells_[slot].key != -1) slot = (slot + 1) & (cells_.size() - 1);
  return slot;
}

void PointGrid::grow() {
  std::vector<Cell> old(cells_.size() * 2);
  old.swap(cells_);
  for (const Cell& cell : old) {
    if (cell.key != -1) cells_[slotOf(cell.key)] = cell;
  }
}

void PointGrid::add(const Vector3& p, double radius) {
  const int level = levelOf(radius);
  const double side = std::ldexp(1.0, level);
  const auto index = [&](double x) { return static_cast<std::int64_t>(std::floor(x / side)); };
  const std::int64_t key = keyOf(level, index(p.x()), index(p.y()), index(p.z()));
  std::size_t slot = slotOf(key);
  if (cells_[slot].key == -1) {
    if (2 * ++used_ > cells_.size()) {
      grow();
      slot = slotOf(key);
    }
    cells_[slot].key = key;
  }
  points_.push_back({p, radius, cells_[slot].first});
  cells_[slot].first = static_cast<std::int32_t>(points_.size() - 1);
}

bool PointGrid::taken(const Vector3& p, double radius) const {
  const int own = levelOf(radius);
  // The own level first: most places are taken there
  for (const int level : {own, own + 1, own - 1}) {
    const double side = std::ldexp(1.0, level);
    const double reach = 0.5 * (radius + side);
    std::int64_t lo[3];
    std::int64_t hi[3];
    for (int k = 0; k < 3; ++k) {
      lo[k] = static_cast<std::int64_t>(std::floor((p[k] - reach) / side));
      hi[k] = static_cast<std::int64_t>(std::floor((p[k] + reach) / side));
    }
    for (std::int64_t x = lo[0]; x <= hi[0]; ++x) {
      for (std::int64_t y = lo[1]; y <= hi[1]; ++y) {
        for (std::int64_t z = lo[2]; z <= hi[2]; ++z) {
          for (std::int32_t i = cells_[slotOf(keyOf(level, x, y, z))].first; i >= 0;
               i = points_[static_cast<std::size_t>(i)].next) {
            const Point& q = points_[static_cast<std::size_t>(i)];
            const double limit = 0.5 * (radius + q.radius);
            if ((q.place - p).squaredNorm() < limit * limit) return true;
          }
        }
      }
    }
  }
  return false;
}

}  // namespace ecorche::domain
