#pragma once

#include <ecorche/tissue/drag_rows.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace ecorche::tissue {

/// Functions along curves that are linear between evenly spaced knots; one per piece where these
/// are few.
class CurveHats {
 public:
  /// @param knots  of each curve, ≥ 2
  CurveHats(const PiecedRows& rows, int knots);

  [[nodiscard]] Eigen::Index count() const { return count_; }

  /// The two functions that are something at a piece.
  struct At {
    Eigen::Index column = 0;
    double here = 0.0;  ///< of column
    double next = 0.0;  ///< of the one after; 0: there may be none
  };
  [[nodiscard]] const At& operator[](std::size_t piece) const { return ofPiece_[piece]; }

  /// M += Pᵀ diag(worth) P, where P has a row per piece.
  void addSquare(const Eigen::VectorXd& worth, Eigen::MatrixXd& M) const;
  /// Pᵀ values, of one row per piece.
  [[nodiscard]] Eigen::MatrixXd project(const Eigen::MatrixXd& values) const;

 private:
  std::vector<At> ofPiece_;
  Eigen::Index count_ = 0;
};

}  // namespace ecorche::tissue
