#pragma once

#include <ecorche/envelope/placing.h>
#include <ecorche/envelope/splitting.h>

#include <span>

namespace ecorche::envelope {

/// Cuts tets anew, so that every child has volume whatever lies inside: the last resort of
/// repair.h.
///
/// The parent's boundary stays as the split left it, triangles, owners and all. A copy of it shrunk
/// to half its size about the centre belongs to one owner; each triangle of the boundary keeps the
/// layer between it and its copy. Layers are thick in every direction, so children are positive as
/// soon as the boundary's triangles are, and the tets of each owner form a manifold: a thickened
/// piece of a surface, or a ball with such pieces on it.
///
/// What the diagram says about the inside is lost: owners that show nowhere on the boundary have
/// nothing, and an owner's pieces on the boundary hang together through the inside only if it is
/// the one that has the middle (of those on the boundary the largest at the centre, ties by rank).
///
/// @param parents    tets of the domain, ascending; their boundary's triangles face outward
/// @param split      gets the new children
/// @param placement  gets the copies, Placed::Repaired; loses the names that have no tet any more
/// @param V          follows the placement
void rebuildTets(const mesh::TetMesh& domain, const tissue::FieldMatrix& fields,
                 std::span<const std::int32_t> parents, Split& split, Placement& placement,
                 mesh::Positions& V);

}  // namespace ecorche::envelope
