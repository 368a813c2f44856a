#pragma once

#include <ecorche/mesh/single_cholesky.h>
#include <ecorche/mesh/tree_solver.h>
#include <ecorche/tissue/tissue_solver.h>

#include <memory>
#include <vector>

namespace ecorche::tissue {

/// What every drag from one settled state stands on: its factor in 32 bits, its matrix row by row.
struct DragGround {
  std::shared_ptr<const TissueSolver> solver;
  mesh::TreeSolver<float> tree;
  std::vector<double> K;  ///< on the solver's pattern, rows of all curves in it
  std::shared_ptr<const mesh::NeighbourRows> rows;
  std::vector<std::int32_t> stubborn;  ///< rows that refined solves need 64 bits for, ascending

  /// @param factor  of these cores, by this solver; not null
  DragGround(std::shared_ptr<const TissueSolver> solver, const TissueSolver::Factor& factor,
             const CoreSamples& cores);
  /// @param factor  of K; ok()
  DragGround(std::shared_ptr<const TissueSolver> solver,
             std::shared_ptr<const mesh::SingleCholesky> factor, std::vector<double> K,
             std::shared_ptr<const mesh::NeighbourRows> rows);
};

/// K += times · Bᵀ W B of some rows.
void addRows(const domain::Domain& domain, const mesh::StiffnessPattern& pattern,
             const std::vector<CoreSample>& samples, double times, std::vector<double>& K);

}  // namespace ecorche::tissue
