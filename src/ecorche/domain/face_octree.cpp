#include <ecorche/core/index.h>
#include <ecorche/domain/face_octree.h>

namespace ecorche::domain {

namespace {}  // namespace

FaceOctree::FaceOctree(const mesh::Box& space) {
  nodes_.push_back(
      {.centre = space.centre().array(), .half = 0.5 * (space.hi - space.lo).maxCoeff()});
}

void FaceOctree::divide(std::int32_t node) {
  const auto first = static_cast<std::int32_t>(nodes_.size());
  const Eigen::Array3d centre = nodes_[toIndex(node)].centre;
  const double half = 0.5 * nodes_[toIndex(node)].half;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Array3d towards((k & 1) ? 1 : -1, (k & 2) ? 1 : -1, (k & 4) ? 1 : -1);
    nodes_.push_back({.centre = centre + half * towards, .half = half, .parent = node});
  }
  nodes_[toIndex(node)].firstChild = first;
}

std::int32_t FaceOctree::nodeFor(const mesh::Box& box) {
  const Eigen::Array3d centre = box.centre().array();
  const double side = (box.hi - box.lo).maxCoeff();
  std::int32_t node = 0;
  // What lies outside stays at the root, which is always looked at
  if (((centre - nodes_[0].centre).abs() > nodes_[0].half).any()) return node;
  for (int depth = 0; depth < kDeepest && nodes_[toIndex(node)].half >= side; ++depth) {
    if (nodes_[toIndex(node)].firstChild < 0) divide(node);
    const Node& here = nodes_[toIndex(node)];
    const auto beyond = centre > here.centre;
    node = here.firstChild + (beyond[0] ? 1 : 0) + (beyond[1] ? 2 : 0) + (beyond[2] ? 4 : 0);
  }
  return node;
}

void FaceOctree::add(std::int32_t number, const mesh::Box& box) {
  if (toIndex(number) >= entries_.size()) entries_.resize(toIndex(number) + 1);
  const std::int32_t node = nodeFor(box);
  Node& home = nodes_[toIndex(node)];
  entries_[toIndex(number)] = {.box = box, .node = node, .next = home.first};
  if (home.first >= 0) entries_[toIndex(home.first)].previous = number;
  home.first = number;
  for (std::int32_t n = node; n >= 0; n = nodes_[toIndex(n)].parent) ++nodes_[toIndex(n)].count;
}

void FaceOctree::remove(std::int32_t number) {
  if (toIndex(number) >= entries_.size() || entries_[toIndex(number)].node < 0) return;
  Entry& entry = entries_[toIndex(number)];
  if (entry.previous >= 0) {
    entries_[toIndex(entry.previous)].next = entry.next;
  } else {
    nodes_[toIndex(entry.node)].first = entry.next;
  }
  if (entry.next >= 0) entries_[toIndex(entry.next)].previous = entry.previous;
  for (std::int32_t n = entry.node; n >= 0; n = nodes_[toIndex(n)].parent)
    --nodes_[toIndex(n)].count;
  entry = {};
}

}  // namespace ecorche::domain
