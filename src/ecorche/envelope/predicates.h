#pragma once

#include <array>
#include <cstdint>

namespace ecorche::envelope {

/// Fields at the corners of a tet: value(c, i) of column i at corner c.
struct CornerFields {
  std::array<const double*, 4> row{};  ///< one row of the field matrix per corner
  [[nodiscard]] double value(int corner, std::int32_t column) const {
    return row[static_cast<std::size_t>(corner)][column];
  }
};

/// Of two columns with equal values the one that counts as larger: ids from 2 upward in order, fat
/// (column 0) last. This stands for f_i + ε_i with ε_2 ≫ ε_3 ≫ … ≫ ε_fat > 0.
[[nodiscard]] constexpr bool comesFirst(std::int32_t a, std::int32_t b) {
  return a != 0 && (b == 0 || a < b);
}

/// A point of a tet where fields meet: fields[0 … count−1] are equal there, and it lies on the
/// sub-simplex of the corners[0 … count−1]. count 1: a corner itself; 2: on an edge; 3: on a face;
/// 4: inside.
struct MeetingPoint {
  int count = 0;
  std::array<int, 4> corners{};
  std::array<std::int32_t, 4> fields{};
};

/// Sign of f_m − f at the meeting point, f the fields that meet there, decided exactly and never 0:
/// ties fall by the order of comesFirst.
///
/// With g = f_m − f_0 and rows D_r = f_r − f_0 over the corners, f_m − f is det[g; D] / det[1; D].
/// Adding ε_i to a field changes det[g; D] linearly, by ε_i times the same determinant with that
/// row replaced by ones, so the first coefficient that is not zero, in order of priority, decides
/// (docs/algorithms/envelope.md).
///
/// @pre  the point exists: the fields have one common point on the affine hull of the corners
[[nodiscard]] int signAbove(const CornerFields& f, const MeetingPoint& point, std::int32_t m);

/// Barycentric coordinates of the point over its corners, in doubles: exact ties and rounding make
/// them only nearly non-negative. Zero everywhere if they cannot be told.
[[nodiscard]] std::array<double, 4> meetingWeights(const CornerFields& f,
                                                   const MeetingPoint& point);

}  // namespace ecorche::envelope
