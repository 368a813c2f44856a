#pragma once

#include <ecorche/mesh/types.h>

#include <vector>

namespace ecorche::domain {

/// Corners of a face, middles of its sides, and points between them no farther apart than the
/// spacing.
/// @param f        row of F
/// @param spacing  [m, > 0]; a side gets at most a dozen points
/// @return  at least six points
[[nodiscard]] std::vector<mesh::Vector3> faceSamples(const mesh::Positions& V,
                                                     const mesh::Triangles& F, Eigen::Index f,
                                                     double spacing);

/// How densely distances between surfaces are looked at that should be less than a tolerance.
inline constexpr double kSampleSpacing = 2.0;  // tolerances

}  // namespace ecorche::domain
