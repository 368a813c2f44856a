#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <vector>

namespace ecorche::mesh {

/// Union-find with path halving. The smallest member is the root, so answers do not depend on the
/// order of unions.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  [[nodiscard]] std::int32_t root(std::int32_t i) {
    while (at(i) != i) i = at(i) = at(at(i));
    return i;
  }
  void unite(std::int32_t i, std::int32_t j) {
    i = root(i);
    j = root(j);
    at(std::max(i, j)) = std::min(i, j);
  }
  /// Numbers the sets from 0 in order of their smallest members; returns how many there are.
  std::int32_t label(std::vector<std::int32_t>& out) {
    out.assign(parent_.size(), -1);
    std::int32_t count = 0;
    for (std::size_t i = 0; i < parent_.size(); ++i) {
      const auto r = static_cast<std::size_t>(root(static_cast<std::int32_t>(i)));
      out[i] = r == i ? count++ : out[r];
    }
    return count;
  }

 private:
  std::int32_t& at(std::int32_t i) { return parent_[static_cast<std::size_t>(i)]; }
  std::vector<std::int32_t> parent_;
};

}  // namespace ecorche::mesh
