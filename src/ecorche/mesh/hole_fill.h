#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/face_repair.h>

namespace ecorche::mesh {

/// Holes no wider than `holeRel` of their piece's diagonal are small, and of less than 20 edges,
/// where a face or two are missing, also wider ones: of n edges 20/n times.
/// @param extent  diagonal of the border's box [m]
/// @param whole   diagonal of the piece's box [m]
[[nodiscard]] bool isSmallHole(double extent, std::size_t edges, double whole, double holeRel);

/// What makeManifold did.
struct ManifoldReport {
  StepReport split;   ///< vertices doubled where too much hung together
  StepReport flat;    ///< faces without area taken out, their neighbours joined
  StepReport filled;  ///< holes filled; size is the widest [m]
};

/// Makes faces agree about their sides, splits edges and vertices that join too much, takes out
/// faces without area and fills small holes (CGAL; see isSmallHole). A border around a sheet that
/// its filling would only double is none. Faces name no vertex twice, and none is doubled.
/// @errors  MeshNotRepairable, Cancelled
[[nodiscard]] Result<ManifoldReport> makeManifold(LabelledFaces& faces, double holeRel,
                                                  RunContext& run);

}  // namespace ecorche::mesh
