#pragma once

#include <ecorche/tissue/drag_ground.h>

#include <Eigen/Core>
#include <span>
#include <vector>

namespace ecorche::tissue {

/// Values and right sides of a few fields.
using TubeBlock = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Gauss–Seidel on some rows of K x = force, all others as they are: what a few unknowns along a
/// curve cannot see is local.
///
/// @param K      on the ground's pattern
/// @param rows   ascending
/// @param force  #rows×#fields
/// @param place  #rows of K, where x has each; −1 where it is nothing
/// @param x      one row for each place
/// @return  the largest change in the last sweep
double sweepTube(const DragGround& ground, const std::vector<double>& K,
                 std::span<const std::int32_t> rows, const TubeBlock& force,
                 std::span<const std::int32_t> place, int sweeps, TubeBlock& x);

/// Rows within so many edges of others, ascending.
[[nodiscard]] std::vector<std::int32_t> rowsAround(const DragGround& ground,
                                                   std::span<const std::int32_t> rows, int edges);

}  // namespace ecorche::tissue
