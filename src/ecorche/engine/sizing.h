#pragma once

#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/tissue/tissue.h>

#include <vector>

namespace ecorche::engine {

/// How thick a muscle can become around a point of its curve.
struct CurveRoom {
  std::vector<mesh::Vector3> point;  ///< along one curve, origin first [m]
  std::vector<double> radius;        ///< half the muscle's expected thickness there [m]
};

/// A guess at every muscle's radius before anything is solved: fields of neighbours meet about
/// midway, so half the distance to the next curve of another tissue, and no more than what lies
/// between the curve and the skin.
///
/// @param tissues  muscles and fillers
/// @param skin     of the uncut body; its vertices stand for it
/// @param floor    radius that no guess goes below [m]: where curves run together they are thin
/// anyway
/// @return one entry per curve of every muscle; fillers get none, their shape is nobody's concern
[[nodiscard]] std::vector<CurveRoom> roomAroundCurves(
    const std::vector<tissue::CurveTissue>& tissues, const mesh::SurfaceMesh& skin, double floor);

}  // namespace ecorche::engine
