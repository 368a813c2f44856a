#pragma once

#include <ecorche/core/parallel.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace ecorche::envelope {

/// Calls body(i, out) for every i in [0, count) and returns everything appended to `out`, in order
/// of i, whatever the number of threads.
template <class Item, class Body>
std::vector<Item> collect(std::int64_t count, const Body& body, std::int64_t grain = 512) {
  const std::int64_t chunks = (count + grain - 1) / grain;
  std::vector<std::vector<Item>> parts(static_cast<std::size_t>(chunks));
  parallelFor(
      chunks,
      [&](std::int64_t c) {
        auto& part = parts[static_cast<std::size_t>(c)];
        for (std::int64_t i = c * grain; i < std::min(count, (c + 1) * grain); ++i) body(i, part);
      },
      1);
  std::vector<std::size_t> first(parts.size() + 1, 0);
  for (std::size_t c = 0; c < parts.size(); ++c) first[c + 1] = first[c] + parts[c].size();
  std::vector<Item> all(first.back());
  parallelFor(
      chunks,
      [&](std::int64_t c) {
        const auto i = static_cast<std::size_t>(c);
        std::ranges::copy(parts[i], all.begin() + static_cast<std::ptrdiff_t>(first[i]));
      },
      1);
  return all;
}

/// Counts to offsets, in place: entry i becomes the sum of all before it, one entry longer.
inline void prefixSum(std::vector<std::int32_t>& counts) {
  std::int32_t sum = 0;
  for (std::int32_t& c : counts) {
    const std::int32_t own = c;
    c = sum;
    sum += own;
  }
  counts.push_back(sum);
}

}  // namespace ecorche::envelope
