#include <ecorche/core/contract.h>
#include <ecorche/tissue/curve_hats.h>

#include <algorithm>

namespace ecorche::tissue {

CurveHats::CurveHats(const PiecedRows& rows, int knots) {
  EC_REQUIRE(knots >= 2);
  std::size_t begin = 0;
  for (const std::int32_t curveEnd : rows.curveEnd) {
    const auto end = static_cast<std::size_t>(curveEnd);
    if (end - begin <= static_cast<std::size_t>(knots)) {
      for (std::size_t p = begin; p < end; ++p) ofPiece_.push_back({count_++, 1.0, 0.0});
    } else {
      double length = 0.0;
      for (std::size_t p = begin; p < end; ++p) length += rows.pieces[p].length;
      double s = 0.0;
      for (std::size_t p = begin; p < end; ++p) {
        const double l = rows.pieces[p].length;
        const double x = (s + 0.5 * l) / length * (knots - 1);
        s += l;
        const auto k = std::min(static_cast<Eigen::Index>(x), static_cast<Eigen::Index>(knots) - 2);
        const double share = x - static_cast<double>(k);
        ofPiece_.push_back({count_ + k, 1.0 - share, share});
      }
      count_ += knots;
    }
    begin = end;
  }
}

void CurveHats::addSquare(const Eigen::VectorXd& worth, Eigen::MatrixXd& M) const {
  EC_REQUIRE_EQ(static_cast<std::size_t>(worth.size()), ofPiece_.size());
  for (std::size_t p = 0; p < ofPiece_.size(); ++p) {
    const At& at = ofPiece_[p];
    const double w = worth[static_cast<Eigen::Index>(p)];
    M(at.column, at.column) += w * at.here * at.here;
    if (at.next == 0.0) continue;
    M(at.column, at.column + 1) += w * at.here * at.next;
    M(at.column + 1, at.column) += w * at.here * at.next;
    M(at.column + 1, at.column + 1) += w * at.next * at.next;
  }
}

Eigen::MatrixXd CurveHats::project(const Eigen::MatrixXd& values) const {
  EC_REQUIRE_EQ(static_cast<std::size_t>(values.rows()), ofPiece_.size());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(count_, values.cols());
  for (std::size_t p = 0; p < ofPiece_.size(); ++p) {
    const At& at = ofPiece_[p];
    out.row(at.column) += at.here * values.row(static_cast<Eigen::Index>(p));
    if (at.next != 0.0)
      out.row(at.column + 1) += at.next * values.row(static_cast<Eigen::Index>(p));
  }
  return out;
}

}  // namespace ecorche::tissue
