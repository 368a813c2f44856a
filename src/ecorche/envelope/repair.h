#pragma once

#include <ecorche/envelope/placing.h>
#include <ecorche/envelope/splitting.h>

namespace ecorche::envelope {

/// World positions: the domain's vertices, then the names where their weights put them.
[[nodiscard]] mesh::Positions positionsOf(const mesh::Positions& V,
                                          const std::vector<Anatomy::Origin>& origin);

struct RepairCount {
  std::int64_t parents =
      0;  ///< tets of the domain that held a child without volume, or next to none
  std::int64_t rebuilt = 0;  ///< of those, cut anew (rebuilding.h)
};

/// Moves new vertices until every child of a mixed tet has positive volume: exactly, in the rounded
/// coordinates.
///
/// Names of tets at fault go part of the way towards their safe places, a little further each
/// round. On faces safe places are good whatever the fields are, inside tets they need not be: what
/// is left then is cut anew.
///
/// @param thin       a child with less than this share of its parent's volume counts as at fault
/// @param split      as splitTets gave it; changes only where tets are cut anew
/// @param placement  entries that were moved are Placed::Repaired
/// @param V          #V + #names; rows of names follow the placement
RepairCount repairPlaces(const mesh::TetMesh& domain, const tissue::FieldMatrix& fields,
                         const Diagram& diagram, double thin, Split& split, Placement& placement,
                         mesh::Positions& V);

}  // namespace ecorche::envelope
