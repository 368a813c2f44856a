#pragma once

#include <ecorche/tissue/drag_ground.h>

#include <functional>

namespace ecorche::tissue {

/// What came of a refinement.
struct Refined {
  bool done = false;        ///< false: stopped, or 32 bits are too few for this matrix
  int passes = 0;           ///< solves with the factor
  double lastStep = 0.0;    ///< of the last pass, over the column's scale
  double visitedShare = 0;  ///< of the rows, by the mean pass
};

/// K X = b to 10⁻⁹ of each column's scale and better: residuals in 64 bits, corrections with the
/// factor in 32 [Higham 2002, §12]. Each pass goes down the elimination tree from the rows where
/// something is left, and back to where corrections are more than nothing: close to a solution, or
/// for right sides of few rows, that is a small part of a solve.
///
/// @param X      #rows×k, where to begin; solved in place
/// @param scale  #k, largest value that a column may take; > 0
/// @param stop   asked between passes
[[nodiscard]] Refined refinedSolve(const DragGround& ground, const FieldMatrix& b,
                                   const Eigen::Ref<const Eigen::VectorXd>& scale, FieldMatrix& X,
                                   const std::function<bool()>& stop = {});

}  // namespace ecorche::tissue
