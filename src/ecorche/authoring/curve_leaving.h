#pragma once

#include <ecorche/authoring/stroke_depth.h>
#include <ecorche/mesh/spline.h>
#include <ecorche/mesh/types.h>

#include <optional>
#include <string>
#include <vector>

namespace ecorche::authoring {

/// Where a curve leaves the domain.
struct Leaving {
  enum class Through { Skin, Bone, Plane };
  Through what = Through::Skin;
  std::string name;  ///< of the bone or plane
  mesh::Vector3 at = mesh::Vector3::Zero();
};

/// Where a curve first goes through skin, bone or a cut plane, or begins beyond one: chords no
/// longer than a two-thousandth of the body against every triangle near, sides decided exactly.
/// What it does within that distance of an end does not count: ends sit on bone.
/// @return  nothing where the curve stays in the domain
[[nodiscard]] std::optional<Leaving> firstLeaving(const mesh::Spline& curve,
                                                  const StrokeRoom& room);

/// The same curve with more control points: the first and last leave the bone steeply, and wherever
/// the curve would still leave the domain it is drawn to a place with room.
///
/// @param points  control points of a curve that is nearly clear; ends are kept
/// @param most    no more than so many control points
/// @return  control points of a curve that does not leave the domain, or nothing
[[nodiscard]] std::optional<std::vector<mesh::Vector3>> clearedCurve(
    const std::vector<mesh::Vector3>& points, const StrokeRoom& room, std::size_t most = 32);

}  // namespace ecorche::authoring
