#pragma once

#include <ecorche/mesh/spline.h>

#include <vector>

namespace ecorche::mesh {

/// Control points of the spline that comes closest to a stroke: least squares of the distances,
/// every stretch of the stroke counted by its length [ABLSJ21 §3.2: four points].
///
/// @param stroke  points in drawing order [m], at least two of them distinct (ContractError
/// otherwise)
/// @param count   how many control points, at least 2
/// @return  `count` points, neighbours distinct, the first and last exactly those of the stroke. A
/// stroke with fewer
///          distinct points gives those; a closed stroke gives at least three. Turned, moved or
///          scaled with the stroke.
[[nodiscard]] std::vector<Vector3> fitSpline(const std::vector<Vector3>& stroke, int count = 4);

}  // namespace ecorche::mesh
