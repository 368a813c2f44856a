#pragma once

#include <ecorche/envelope/predicates.h>

#include <array>
#include <cstdint>
#include <vector>

namespace ecorche::envelope {

/// A corner of a cell: the meeting of three planes, each a face of the tet (0 … 3, opposite that
/// corner) or the bisector with another candidate (4 + its place among the candidates). Ascending.
using CellCorner = std::array<std::int16_t, 3>;

/// A face of a cell: which plane, and its corners in order, counter-clockwise seen from outside the
/// cell.
struct CellFace {
  std::int16_t plane = 0;
  std::vector<std::int16_t> loop;
};

/// Where one field is the largest inside one tet: a convex polytope in which three faces meet at
/// every corner.
struct Cell {
  std::int16_t candidate = 0;
  std::vector<CellCorner> corners;
  std::vector<CellFace> faces;
  [[nodiscard]] bool empty() const { return faces.empty(); }
};

/// Cuts the cells of a tet: the tet is clipped by the bisectors of one candidate with all others,
/// deciding on which side every corner lies by exact predicates, so neighbours see the same
/// polygons on the face they share.
class CellCutter {
 public:
  /// Cells of all candidates that show in the tet, in candidate order. References stay valid until
  /// the next call.
  /// @param candidates  columns, distinct; every field that shows must be among them
  const std::vector<Cell>& cut(const CornerFields& f, const std::vector<std::int32_t>& candidates);

  /// The point that a cell's corner stands for.
  [[nodiscard]] static MeetingPoint pointOf(const std::vector<std::int32_t>& candidates,
                                            std::int16_t candidate, const CellCorner& corner);

 private:
  std::vector<Cell> cells_;
  std::vector<std::int8_t> side_;
  std::vector<std::int16_t> fresh_;

  void startFromTet(Cell& cell) const;
  void clip(Cell& cell, const CornerFields& f, const std::vector<std::int32_t>& candidates,
            std::int16_t other);
};

}  // namespace ecorche::envelope
