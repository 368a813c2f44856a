#pragma once

#include <ecorche/render/volume_item.h>

#include <vector>

namespace ecorche::render {

/// How deep each tissue lies, for peeling an anatomy from outside in: 0 for those met first under
/// the boundary, 1 for those under them, and so on without gaps.
///
/// Rays go in through the boundary, spread evenly over its faces; each counts the tissues that it
/// meets before one, fat and `ignored` left out. A tissue is as deep as a quarter of the rays that
/// meet it say, since those from its far side know nothing of how near it lies to the skin.
///
/// @param ignored  by tissue id − 1, or empty; fat is always
/// @return  by tissue id − 1; -1 for fat, what is ignored and what no ray meets
[[nodiscard]] std::vector<int> layersFromOutside(const VolumeItem& item,
                                                 const std::vector<bool>& ignored = {});

}  // namespace ecorche::render
