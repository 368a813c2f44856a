#pragma once

#include <ecorche/authoring/first_curves.h>
#include <ecorche/mesh/types.h>

#include <vector>

namespace ecorche::authoring {

/// A line of sight.
struct SightRay {
  mesh::Vector3 origin = mesh::Vector3::Zero();      // [m]
  mesh::Vector3 direction = mesh::Vector3::UnitY();  // unit
};

/// A stroke drawn over the picture, in depth: every point lies on its own line of sight, and its
/// distance from the eye goes linearly from that of the first point to that of the last, along the
/// stroke [ABLSJ21 §3.2].
///
/// @param sights  lines of sight through the points of the stroke, at least two
/// @param from    where the stroke begins, on its first line of sight [m]
/// @param to      where it ends, on its last [m]
/// @return  a point for each line of sight; the first and last are `from` and `to`
[[nodiscard]] std::vector<mesh::Vector3> strokeInDepth(const std::vector<SightRay>& sights,
                                                       const mesh::Vector3& from,
                                                       const mesh::Vector3& to);

/// Control points of the stroke alone, whatever lies in its way: four by least squares [ABLSJ21
/// §3.2].
/// @param path  at least two distinct points; its ends are kept
[[nodiscard]] std::vector<mesh::Vector3> fittedStroke(const std::vector<mesh::Vector3>& path);

/// Control points of a first curve along a stroke: four by least squares where that curve stays
/// inside the skin and out of bones; else it is bent like a thin beam, just as far as it takes to
/// keep clear of both, and gets as many points as that needs, up to twenty.
///
/// @param path    the stroke in space, at least two distinct points; its ends are kept
/// @param around  what is in the way
[[nodiscard]] std::vector<mesh::Vector3> strokeCurve(const std::vector<mesh::Vector3>& path,
                                                     const Surroundings& around);

}  // namespace ecorche::authoring
