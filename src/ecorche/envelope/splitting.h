#pragma once

#include <ecorche/envelope/diagram.h>
#include <ecorche/mesh/tet_mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace ecorche::envelope {

/// A tet of the subdivision; vertex numbers as in Diagram.
struct SubTet {
  std::array<std::int32_t, 4> vertex{};
  std::int32_t column = -1;  ///< owner
};

/// The domain's tets cut along the diagram, in order of their parents.
struct Split {
  mesh::Tets T;
  std::vector<std::int32_t> column;      ///< #T owner
  std::vector<std::int32_t> parent;      ///< #T
  std::vector<std::int32_t> firstChild;  ///< #parents + 1
};

/// Every cell is pulled from its vertex of lowest number: faces as polygons first, then cells as
/// cones over the faces that do not hold that vertex. Both sides of a face see the same polygons
/// with the same numbers, so they agree. Orientation is combinatorial: children have their parent's
/// wherever their vertices are placed without folding.
[[nodiscard]] Split splitTets(const mesh::Tets& T, const Diagram& diagram);

/// Children of a mixed tet with two owners: a table. 4 or 6 of them.
/// @param m  index into diagram.mixed
void splitTwoOwners(const mesh::Tets& T, const Diagram& diagram, std::int32_t m,
                    std::vector<SubTet>& out);

/// Children of a mixed tet with any number of owners: its cells as polytopes.
/// @param x  index into diagram.complex
void splitCells(const mesh::Tets& T, const Diagram& diagram, std::int32_t x,
                std::vector<SubTet>& out);

}  // namespace ecorche::envelope
