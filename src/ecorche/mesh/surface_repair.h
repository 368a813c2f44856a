#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_mesh.h>

namespace ecorche::mesh {

/// Lengths are shares of the bounding-box diagonal.
struct RepairOptions {
  /// Vertices on borders closer than this are made one, which closes cracks; less where border
  /// edges are shorter. 0: only vertices at exactly the same place.
  double weldRel = 1e-5;
  /// Pieces smaller than this, next to larger ones, are dropped. 0: none.
  double speckRel = 1e-3;
  /// Holes no wider than this share of their piece's diagonal are filled; of n < 20 edges, where a
  /// face or two are missing, up to 20/n times as wide. 0: none.
  double holeRel = 0.05;
  /// A skin: what is open in the end is an error, otherwise a warning; sheets, and crumbs that
  /// touch nothing, are left out.
  bool mustClose = false;
  /// Open sheets that enclose nothing (see openSheets) are left out, of what need not close too.
  bool leaveOutSheets = false;
};

struct RepairedSurface {
  SurfaceMesh mesh;   ///< compact, consistently oriented, outward where closed; parts kept
  Findings findings;  ///< what was done (Repaired) and what is left to be seen (Warning, Note),
                      ///< each with place and size
};

/// Repairs what is certain and says so [DESIGN §5.2]: merges equal and almost equal vertices, drops
/// doubled faces, faces without area, inner walls, walls between touching pieces and specks, splits
/// edges and vertices that join too much, makes faces agree about their sides, fills small holes
/// and turns pieces outward. Inward pieces within outward ones are walls of cavities and stay. A
/// sound mesh comes back as it is, without its unused vertices.
///
/// Self-intersections and large holes are left alone.
/// @errors  NonFiniteVertex, MeshWithoutFaces (nothing is left), SkinNotClosed (the place is the
/// largest hole's),
///          MeshNotRepairable, Cancelled
[[nodiscard]] Result<RepairedSurface> repairSurface(const SurfaceMesh& mesh,
                                                    const RepairOptions& options, RunContext& run);

}  // namespace ecorche::mesh
