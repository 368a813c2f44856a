#pragma once

#include <ecorche/domain/tet_files.h>

namespace ecorche::domain {

/// Tets inside a closed surface by CGAL Mesh_3 [Jamin et al. 2015], for surfaces that TetGen
/// refuses.
///
/// Slower and rounder than TetGen: the surface is approximated anew within the tolerance, ridges
/// sharper than 40° are kept. Vertices of faces on cut planes are put onto their plane. Cannot be
/// stopped, may never end and leaves a dump in the working folder where it fails: for a process of
/// its own (`ecorche-worker fill`).
/// @errors  MeshingFailed
[[nodiscard]] Result<TetAnswer> fillByMesh3(const FillRequest& request);

}  // namespace ecorche::domain
