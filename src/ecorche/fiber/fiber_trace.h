#pragma once

#include <ecorche/fiber/fiber_ends.h>
#include <ecorche/fiber/muscle_mesh.h>

#include <vector>

namespace ecorche::fiber {

/// Traced fibres of one muscle.
struct TracedFibers {
  std::vector<std::vector<mesh::Vector3>> lines;  ///< origin first
  std::vector<double> length;                     ///< of each [m]
};

/// Follows the vertex directions from seeds that cover the section u = ½ evenly by area, both ways,
/// until u has gone from `share` to 1 − `share` or the fibre leaves through an end. Fibres that
/// stick to the muscle's side slide along it; those that stop on the way are not returned.
///
/// @param u       flow at the vertices
/// @param vertexFiber  #V×3 unit directions
/// @param attached  #V, not zero on vertices of attachments
/// @param step    distance between points [m]
[[nodiscard]] TracedFibers traceFibers(const MuscleMesh& muscle, const Eigen::VectorXd& u,
                                       const mesh::Directions& vertexFiber,
                                       const std::vector<std::uint8_t>& attached, int count,
                                       double step, double share);

}  // namespace ecorche::fiber
