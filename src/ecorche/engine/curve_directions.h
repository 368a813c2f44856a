#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/mesh/surface_mesh.h>

#include <memory>
#include <vector>

namespace ecorche::engine {

/// A first idea of the fibres, for pictures: at every vertex the direction of its owner's curves
/// where they are nearest.
///
/// @param owner  #V
/// @param lines  curves by tissue id − 1, each a polyline; none: the tissue has no direction
/// @return  #V×3, unit; zero where there is none
[[nodiscard]] std::shared_ptr<const mesh::Directions> curveDirections(
    const mesh::Positions& V, const std::vector<TissueId>& owner,
    const std::vector<std::vector<std::vector<mesh::Vector3>>>& lines);

}  // namespace ecorche::engine
