#pragma once

#include <ecorche/domain/build_domain.h>
#include <ecorche/domain/carve.h>
#include <ecorche/mesh/surface_repair.h>

namespace ecorche::domain {

struct PreparedMeshes {
  CarveInput carve;
  Findings findings;  ///< what was seen and repaired, skin first
  std::int64_t bones = 0;
};

/// Steps 1 and 2 of docs/algorithms/domain.md: every mesh is checked, and repaired where that is
/// certain. What cuts itself is taken for what it encloses; shells within shells go; holes of the
/// skin that lie beyond a cut plane are closed, since they are cut away anyway.
///
/// @param movedRel  how far a repair may move a surface, as a share of the skin's diagonal
/// @errors  NonFiniteVertex, MeshWithoutFaces, SkinNotClosed, MeshNotRepairable; UnitsDiffer (bones
///          that would fit in another unit), Cancelled
[[nodiscard]] Result<PreparedMeshes> prepareMeshes(const DomainInput& input, double movedRel,
                                                   RunContext& run);

/// One of them, apart from the others.
struct PreparedMesh {
  mesh::RepairedSurface surface;
  double moved = 0.0;  ///< by thinning out [m]
  bool fit = false;    ///< for exact subtraction; what is not is wrapped, or for a skin refused
};
/// @param mustClose  a skin must; anything else that is open is wrapped later
/// @param allowed    how far a repair may move the surface [m]
/// @errors  those of mesh::repairSurface
[[nodiscard]] Result<PreparedMesh> prepareMesh(const mesh::SurfaceMesh& mesh, bool mustClose,
                                               double allowed, RunContext& run);

}  // namespace ecorche::domain
