#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace ecorche::mesh {

using Vector3 = Eigen::Vector3d;
using Positions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;        // #V×3 [m]
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;  // #F×3
using Tets = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 4, Eigen::RowMajor>;       // #T×4
using Directions = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;       // unit rows

/// Corner k's opposite face, seen from outside a positively oriented tet (counter-clockwise).
inline constexpr int kTetFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
inline constexpr int kTetEdge[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

}  // namespace ecorche::mesh
