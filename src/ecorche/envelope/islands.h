#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/envelope/diagram.h>
#include <ecorche/envelope/tissue_in_tet.h>
#include <ecorche/mesh/tet_mesh.h>
#include <ecorche/tissue/tissue_fields.h>

#include <span>
#include <vector>

namespace ecorche::envelope {

/// Every tet and tissue of the samples once, ascending.
[[nodiscard]] std::vector<TissueInTet> curveTets(const tissue::CoreSamples& cores);

struct Islands {
  Diagram diagram;                  ///< without islands
  std::vector<TissueInTet> struck;  ///< ascending
  std::int64_t count = 0;           ///< islands struck
  std::int64_t kept = 0;            ///< islands that stay because nothing else could own their tets
  std::int64_t fatPockets = 0;      ///< components of fat beyond the first; they stay
  std::vector<double> volume;       ///< per tissue id, what it lost [m³]
  std::vector<TissueId> lost;       ///< tissues of which no part holds one of their curves
};

/// The diagram without islands: parts of a tissue (not of fat), connected through faces, in which
/// none of its curves runs. Takes the tissue out of the tets of each island, computes again, until
/// there is none.
///
/// Why that keeps the cut conforming although tissues are struck tet by tet: where an island shows
/// on a face, an edge or a vertex it shows in all tets around, and these are connected through
/// faces on which it shows too, so all of them strike it. A later round can break this, when a
/// second island stood in front of the first tissue: then that tissue shows on a shared face from
/// one side and is struck on the other. If what shows is an island again it is struck like any
/// other; if it holds its curve the tissue is admitted again behind that face, once, and has
/// thereby joined its neighbour. Should the same come up a second time it is struck around that tet
/// as well.
///
/// @param seeds  tets through which a tissue's curve runs
/// @errors NonFiniteField, Cancelled, Internal
[[nodiscard]] Result<Islands> strikeIslands(const mesh::TetMesh& mesh,
                                            const mesh::TetNeighbours& neighbours,
                                            const tissue::FieldMatrix& fields, bool fatIsCandidate,
                                            std::span<const TissueInTet> seeds, RunContext& run);

}  // namespace ecorche::envelope
