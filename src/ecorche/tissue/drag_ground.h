#pragma once

#include <ecorche/mesh/single_cholesky.h>
#include <ecorche/mesh/tree_solver.h>
#include <ecorche/tissue/tissue_solver.h>

#include <memory>
#include <vector>

namespace ecorche::tissue {

/// Settled equations, for what goes on from there: their matrix row by row, its factor in 32 bits.
struct DragGround {
  std::shared_ptr<const mesh::StiffnessPattern> pattern;
  std::shared_ptr<const mesh::SymbolicCholesky> symbolic;
  mesh::TreeSolver<float> tree;
  std::shared_ptr<const mesh::SingleCholesky> single;  ///< what it solves with; null: its own copy
  std::vector<double> K;                               ///< on the pattern, rows of all curves in it
  std::shared_ptr<const mesh::NeighbourRows> rows;
  std::vector<std::int32_t> stubborn;  ///< rows that refined solves need 64 bits for, ascending

  /// What fat and isotropic tissues share.
  /// @param factor  of these cores, by this solver; not null
  DragGround(const std::shared_ptr<const TissueSolver>& solver, const TissueSolver::Factor& factor,
             const CoreSamples& cores);
  /// @param tree  with a factor of K
  DragGround(std::shared_ptr<const mesh::StiffnessPattern> pattern,
             std::shared_ptr<const mesh::SymbolicCholesky> symbolic, mesh::TreeSolver<float> tree,
             std::vector<double> K, std::shared_ptr<const mesh::NeighbourRows> rows);

  [[nodiscard]] double diagonal(std::int32_t row) const {
    return K[static_cast<std::size_t>(pattern->diagonal(row))];
  }
};

/// K += times · Bᵀ W B of some rows.
void addRows(const mesh::TetMesh& mesh, const mesh::StiffnessPattern& pattern,
             const std::vector<CoreSample>& samples, double times, std::vector<double>& K);

}  // namespace ecorche::tissue
