#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace ecorche::domain {

/// Boxes by number that come and go, of any sizes, and those of them that meet a given box: a loose
/// octree [Ulrich 2000]. Every box hangs at the cube that its centre lies in, of the smallest size
/// that is no smaller than the box; so it lies within the cube grown by half on all sides.
class FaceOctree {
 public:
  /// @param space  where boxes will lie; what lies outside of it is found too, only slower
  explicit FaceOctree(const mesh::Box& space);

  /// `number` may be any that is not in the tree, 0 and more.
  void add(std::int32_t number, const mesh::Box& box);
  /// Nothing happens to numbers that are not in the tree.
  void remove(std::int32_t number);
  [[nodiscard]] bool holds(std::int32_t number) const {
    return static_cast<std::size_t>(number) < entries_.size() &&
           entries_[static_cast<std::size_t>(number)].node >= 0;
  }

  /// fn(number) for all whose boxes meet `box`, in no order, until one returns true.
  /// @return  whether one did
  template <class Fn>
  bool visit(const mesh::Box& box, const Fn& fn) const;

 private:
  static constexpr int kDeepest = 24;
  struct Node {
    Eigen::Array3d centre;
    double half = 0.0;             // of the cube's side
    std::int32_t firstChild = -1;  // of eight
    std::int32_t parent = -1;
    std::int32_t first = -1;  // entry that hangs here
    std::int32_t count = 0;   // of entries here and below
  };
  struct Entry {
    mesh::Box box;
    std::int32_t node = -1;  // -1: not in the tree
    std::int32_t next = -1;
    std::int32_t previous = -1;
  };
  [[nodiscard]] std::int32_t nodeFor(const mesh::Box& box);
  void divide(std::int32_t node);

  std::vector<Node> nodes_;
  std::vector<Entry> entries_;  // by number
};

template <class Fn>
bool FaceOctree::visit(const mesh::Box& box, const Fn& fn) const {
  const auto meets = [&](const Eigen::Array3d& lo, const Eigen::Array3d& hi) {
    return (lo <= box.hi.array()).all() && (hi >= box.lo.array()).all();
  };
  std::array<std::int32_t, 7 * kDeepest + 8> stack;
  std::size_t top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Node& node = nodes_[static_cast<std::size_t>(stack[--top])];
    for (std::int32_t e = node.first; e >= 0; e = entries_[static_cast<std::size_t>(e)].next) {
      const mesh::Box& own = entries_[static_cast<std::size_t>(e)].box;
      if (meets(own.lo.array(), own.hi.array()) && fn(e)) return true;
    }
    if (node.firstChild < 0) continue;
    for (std::int32_t child = node.firstChild; child < node.firstChild + 8; ++child) {
      const Node& c = nodes_[static_cast<std::size_t>(child)];
      if (c.count > 0 && meets(c.centre - 2.0 * c.half, c.centre + 2.0 * c.half))
        stack[top++] = child;
    }
  }
  return false;
}

}  // namespace ecorche::domain
