#pragma once

#include <ecorche/tissue/drag_ground.h>

#include <functional>
#include <span>

namespace ecorche::tissue {

/// Right sides that are nothing in most rows.
struct SparseSides {
  std::vector<std::int32_t> place;  ///< #rows, row of `value`; −1: nothing
  FieldMatrix value;                ///< #rows with something × k

  /// @param rows  of K, where something will be
  SparseSides(std::int32_t rowCount, std::vector<std::int32_t> rows, Eigen::Index columns);
  [[nodiscard]] SparseSides some(const std::vector<Eigen::Index>& columns) const;

 private:
  SparseSides() = default;
};

/// Bᵀ W of some rows.
/// @param worth  #samples×k, what each row asks for
[[nodiscard]] SparseSides sidesOf(const mesh::TetMesh& mesh, const mesh::StiffnessPattern& pattern,
                                  const std::vector<CoreSample>& samples, const FieldMatrix& worth);
/// Rows where equations of one pattern are others: both ends of every entry, and right sides.
/// @param before, after  values on the pattern; both empty: the same
[[nodiscard]] std::vector<std::int32_t> rowsThatDiffer(const mesh::StiffnessPattern& pattern,
                                                       const std::vector<double>& before,
                                                       const std::vector<double>& after);
[[nodiscard]] std::vector<std::int32_t> rowsThatDiffer(const mesh::StiffnessPattern& pattern,
                                                       const std::vector<double>& before,
                                                       const SparseSides& sidesBefore,
                                                       const std::vector<double>& after,
                                                       const SparseSides& sidesAfter);

/// What came of a refinement.
struct Refined {
  bool done = false;                   ///< false: stopped, or 32 bits are too few for this matrix
  int passes = 0;                      ///< solves with the factor
  double lastStep = 0.0;               ///< of the last pass, over the column's scale
  double visitedShare = 0;             ///< of the rows, by the mean pass
  Eigen::Index leftOut = 0;            ///< columns that passes after the first did not look at
  std::vector<std::int32_t> stubborn;  ///< rows that took 64 bits: ground.stubborn and more
};

/// K X = b to 10⁻⁹ of each column's scale and better: residuals in 64 bits, corrections with the
/// factor in 32 [Higham 2002, §12]. Each pass goes down the elimination tree from the rows where
/// something is left, and back to where corrections are more than nothing: close to a solution, or
/// for right sides of few rows, that is a small part of a solve. Where a few rows hold on to each
/// other so much that 32 bits cannot tell them apart (slivers), they are solved for among
/// themselves after each pass.
///
/// @param X      #rows×k, where to begin; solved in place
/// @param scale  #k, largest value that a column may take; > 0
/// @param stop   asked between passes
/// @param changed  where X solves another system but for these rows: the first pass begins there.
///                 Columns that it does not change by 3·10⁻¹⁰ of their scale are left out then
/// @param allColumns  none is: what is left of each change that is left out adds up
[[nodiscard]] Refined refinedSolve(const DragGround& ground, const SparseSides& b,
                                   const Eigen::Ref<const Eigen::VectorXd>& scale, FieldMatrix& X,
                                   const std::function<bool()>& stop = {},
                                   std::span<const std::int32_t> changed = {},
                                   bool allColumns = false);

}  // namespace ecorche::tissue
