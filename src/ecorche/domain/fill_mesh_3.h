#pragma once

#include <ecorche/core/run_context.h>
#include <ecorche/domain/resample.h>
#include <ecorche/domain/tet_files.h>

namespace ecorche::domain {

/// Tets inside a closed surface by CGAL Mesh_3 [Jamin et al. 2015], for surfaces that TetGen
/// refuses.
///
/// Slower and rounder than TetGen: the surface is approximated anew within `tolerance`, ridges
/// sharper than 40° are kept. Vertices of faces on cut planes are put onto their plane.
/// @param edgeLength  wanted length of edges [m]
/// @param tolerance   how far the boundary of the tets may lie from the surface [m]
/// @errors  MeshingFailed, Cancelled
[[nodiscard]] Result<TetAnswer> fillByMesh3(const TaggedSurface& surface,
                                            const std::vector<CutPlane>& cutPlanes,
                                            const LengthField& edgeLength, double tolerance,
                                            RunContext& run);

}  // namespace ecorche::domain
