#pragma once

#include <ecorche/envelope/envelope.h>
#include <ecorche/envelope/tet_cells.h>

#include <array>
#include <cstdint>
#include <vector>

namespace ecorche::envelope {

/// The name of a new vertex: fields that meet on an edge, in a face or inside a tet. Neighbours
/// that see the same point give it the same name. Unused places are -1.
struct VertexName {
  std::array<std::int32_t, 4> vertex{-1, -1, -1, -1};  ///< of the domain, ascending
  std::array<std::int16_t, 4> field{-1, -1, -1, -1};   ///< columns, ascending
  /// 2: on an edge, 3: in a face, 4: in a tet.
  [[nodiscard]] int count() const { return vertex[2] < 0 ? 2 : vertex[3] < 0 ? 3 : 4; }
  auto operator<=>(const VertexName&) const = default;
};

/// Cells of one tet with two tissues or more, or of one where an island was struck.
struct SplitTet {
  struct Face {
    std::int16_t plane = 0;  ///< 0 … 3: on the tet's face opposite that corner; else inside
    std::vector<std::int16_t> loop;  ///< 0 … 3: the tet's corners; from 4 on: names
  };
  struct Cell {
    std::int16_t column = 0;
    std::vector<Face> faces;
  };
  std::int32_t tet = -1;
  bool struck = false;
  std::vector<VertexName> names;
  std::vector<std::int32_t> id;  ///< output vertex of every name, once numbered
  std::vector<Cell> cells;       ///< by column

  [[nodiscard]] std::int32_t vertex(const mesh::Tets& T, std::int16_t local) const {
    return local < 4 ? T(tet, local) : id[static_cast<std::size_t>(local - 4)];
  }
};

/// The combinatorial half of the envelope: who owns what, and the cells of every tet that is not
/// one tissue's alone.
struct CellComplex {
  std::vector<std::int16_t> owner;    ///< #T column of a tet with one tissue, -1 for a split tet
  std::vector<SplitTet> split;        ///< by tet
  std::vector<std::int32_t> splitOf;  ///< #T place in `split`, -1
  std::int64_t islands = 0;
  std::int64_t fatPockets = 0;
  std::vector<double> islandVolume;  ///< per tissue id [m³]
};

/// Exact subdivision of all tets, islands struck as the options say.
/// @errors NonFiniteField, Cancelled
[[nodiscard]] Result<CellComplex> buildCells(const mesh::TetMesh& mesh,
                                             const mesh::TetNeighbours& neighbours,
                                             const tissue::FieldMatrix& fields,
                                             const EnvelopeOptions& options, RunContext& run);

}  // namespace ecorche::envelope
