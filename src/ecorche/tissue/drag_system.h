#pragma once

#include <ecorche/tissue/drag_ground.h>
#include <ecorche/tissue/drag_rows.h>
#include <ecorche/tissue/tube_sweeps.h>

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

namespace ecorche::tissue {

/// How closely drags follow (docs/algorithms/interactive.md). Shares are of the largest tissue
/// value.
struct DragOptions {
  /// Fields that change by less are left as they are, and so is every vertex where all would.
  double tolerance = 0.004;
  /// The flux along a curve is linear between so many places.
  int knots = 30;
  /// Over the tets near the curve, where it was and where it is.
  int sweeps = 8;
};

/// One system of equations under the hand: fields that share a matrix follow rows that move.
///
/// Only those rows change: K' = K − B_oᵀ W_o B_o + B_nᵀ W_n B_n. The factor of K stays. What old
/// rows read and what new ones pull is smooth along a curve, so some thirty hats stand for hundreds
/// of rows: a small Woodbury system, whose columns go down the elimination tree from the curve to
/// the root alone and come back where they matter (mesh/tree_solver.h). What that misses is local:
/// a few Gauss–Seidel sweeps over the tets near the curves (tube_sweeps.h). See
/// docs/algorithms/interactive.md for what was measured.
class DragSystem {
 public:
  /// What every row asks of every field, #samples×#fields.
  using Targets = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// Writes the settled values of all fields at a vertex of the mesh, as the equations gave them.
  using Settled = std::function<void(std::int32_t vertex, double* values)>;

  /// @param ground    kept
  /// @param mesh      that the ground's pattern is of; kept by reference
  /// @param old       rows that move, where they are settled
  /// @param targets   of those
  /// @param settled   must answer as long as this lives
  /// @param maxValue  largest value of all tissues
  DragSystem(std::shared_ptr<const DragGround> ground, const mesh::TetMesh& mesh, PiecedRows old,
             Targets targets, Settled settled, double maxValue, DragOptions how);
  ~DragSystem();
  DragSystem(DragSystem&&) noexcept;
  DragSystem& operator=(DragSystem&&) noexcept;

  /// Which fields of all tissues rows ask for what: their own for the tissue value there.
  /// @param fields  columns of TissueFields::values, fat first
  [[nodiscard]] static Targets tissueTargets(const PiecedRows& rows,
                                             const std::vector<std::int32_t>& fields);

  /// What some fields have changed by.
  struct Part {
    std::vector<std::int32_t> row;     ///< of the ground's pattern
    std::vector<std::int32_t> fields;  ///< which, as they were given; ascending
    TubeBlock change;                  ///< #row×#fields
    double lastStep = 0.0;             ///< of the sweeps: what is left is of its size
  };
  /// From the settled fields, not from those of the move before: nothing piles up.
  /// @return  parts of different fields
  [[nodiscard]] std::vector<Part> move(const PiecedRows& now, const Targets& targets);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::tissue
