#pragma once

#include <ecorche/domain/tagged_surface.h>

#include <vector>

namespace ecorche::domain {

/// A part of the domain that no skin bounds: the hollow of a bone, a gap that bones close in.
struct Pocket {
  double volume = 0.0;  ///< [m³]
  mesh::Vector3 place = mesh::Vector3::Zero();
  std::vector<std::int32_t> tags;  ///< of its walls, ascending, each once
};

/// Takes out parts without skin that are smaller than the largest part with skin, walls and all
/// that is in them. What is left of that kind is no hollow, but tissue that lacks its skin.
/// @param surface  closed and manifold, facing out of the domain
[[nodiscard]] std::vector<Pocket> dropPockets(TaggedSurface& surface);

}  // namespace ecorche::domain
