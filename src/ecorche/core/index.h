#pragma once

#include <cstddef>
#include <cstdint>

namespace ecorche {

/// Eigen and our meshes count with sign, the standard's containers without: an index of theirs from
/// one of ours, which nobody calls with less than zero.
constexpr std::size_t toIndex(std::int64_t i) { return static_cast<std::size_t>(i); }

}  // namespace ecorche
