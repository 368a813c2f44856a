#pragma once

#include <ecorche/tissue/tissue_fields.h>

#include <array>
#include <cstdint>
#include <limits>

namespace ecorche::envelope {

using tissue::FieldMatrix;

/// Place of a field's column in the order of ties: columns 1, 2, … first, fat (column 0) last.
/// Field i counts as f_i + ε_i with infinitely small ε of falling size in this order, the same
/// everywhere (docs/algorithms/envelope.md §2).
[[nodiscard]] constexpr std::int32_t tieRank(std::int32_t column) {
  return column == 0 ? std::numeric_limits<std::int32_t>::max() : column;
}

/// Whether field i counts as larger than field j where they have these values.
[[nodiscard]] constexpr bool beats(double valueI, std::int32_t i, double valueJ, std::int32_t j) {
  return valueI > valueJ || (valueI == valueJ && tieRank(i) < tieRank(j));
}

/// The point at which N fields are equal inside a simplex of N vertices (an edge, a face, a tet).
///
/// The fields are linear in the simplex and must cross transversally there. Every answer is that of
/// the perturbed fields and exact: doubles decide where their error bound allows, integers of any
/// length where it does not.
template <int N>
class TiedPoint {
 public:
  using Indices = std::array<std::int32_t, N>;

  TiedPoint(const FieldMatrix& fields, const Indices& vertices, const Indices& columns);

  /// Whether the field of that column (none of the tied ones) is larger than them at this point.
  /// Never a tie.
  [[nodiscard]] bool isBelow(std::int32_t column) const;

  /// Weights of the vertices at the point of the unperturbed fields, sum 1, off by at most 1e-11.
  /// Ties and rounding may leave zeros and −1e-11.
  [[nodiscard]] std::array<double, N> barycentric() const;

 private:
  [[nodiscard]] int exactSide(std::int32_t column) const;

  const FieldMatrix& fields_;
  Indices vertices_;
  Indices columns_;
  int sign_;  ///< of D, see the source
};

/// How many fields of columns [first, F.cols()) are not certainly below the crossing of i (on top
/// at vertex a) and j (on top at b) on edge ab. i and j themselves are counted, so 2 means that
/// nothing else shows on the edge.
[[nodiscard]] int fieldsNotBelowCrossing(const FieldMatrix& fields, std::int32_t a, std::int32_t b,
                                         std::int32_t i, std::int32_t j, std::int32_t first);

extern template class TiedPoint<2>;
extern template class TiedPoint<3>;
extern template class TiedPoint<4>;

}  // namespace ecorche::envelope
