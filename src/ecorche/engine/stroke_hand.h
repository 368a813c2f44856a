#pragma once

#include <ecorche/authoring/stroke_depth.h>
#include <ecorche/engine/stroke_atlas.h>

#include <cstdint>
#include <string>
#include <vector>

namespace ecorche::engine {

/// A stroke as a hand would draw it.
struct HandStroke {
  std::string view;  ///< "lateral", "cranial-lateral" …
  int hidden = 0;    ///< ends that lie on the far side of their own bone from here
  std::vector<authoring::SightRay> sights;
  mesh::Vector3 from, to;  ///< where the first and last line of sight meet the bones [m]
};

/// A muscle drawn from three sides, by an eye with the window's field of view, so far off that the
/// muscle takes a third of the picture's height. The hand follows the centreline in the picture,
/// but wanders off it by some pixels and trembles.
///
/// An artist turns the body until both ends are seen and hides what other bones are in front of
/// them: of 18 sides at steps of 45° those three are taken from which both ends are seen on their
/// own bones, the muscle is not looked at end on, and which are nearest to lateral. Where there are
/// fewer, the end is where the line of sight meets the near side of its bone.
///
/// @param fixedViews  lateral, and 45° from there to the front and to the back, for all muscles
/// @param seed        of the hand
[[nodiscard]] std::vector<HandStroke> handStrokes(const KnownMuscle& muscle,
                                                  const StrokeAtlas& atlas, bool fixedViews,
                                                  std::uint64_t seed);

}  // namespace ecorche::engine
