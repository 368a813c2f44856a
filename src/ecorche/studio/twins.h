#pragma once

#include <ecorche/engine/live_engine.h>
#include <ecorche/model/commands.h>

#include <optional>
#include <string>
#include <vector>

namespace ecorche::studio {

// A muscle and its mirror image on the other side, made once or kept in step.

/// A plane that mirrors the body.
struct MirrorPlane {
  mesh::Vector3 point = mesh::Vector3::Zero();    // [m]
  mesh::Vector3 normal = mesh::Vector3::UnitY();  // unit

  [[nodiscard]] mesh::Vector3 image(const mesh::Vector3& p) const {
    return p - 2.0 * (p - point).dot(normal) * normal;
  }
};
/// The project's symmetry plane, if it has one.
[[nodiscard]] std::optional<MirrorPlane> symmetryPlane(const model::Project& project);
/// The plane that mirrors a skin (authoring::findSymmetryPlane); where none does, as of an arm by
/// itself, one through its middle, across the axis along which its halves are most alike. Nothing
/// without a skin.
[[nodiscard]] std::optional<MirrorPlane> mirrorPlane(const mesh::SurfaceMesh& skin);

/// What makes `twin` the image of a muscle, with the bones of that side; where it is there already
/// only what differs. Ends come to lie on the bone of that side, if one is near.
/// @param meshes  may be null
[[nodiscard]] std::vector<model::Command> imageOf(const model::Project& project,
                                                  const engine::LiveMeshes* meshes,
                                                  const model::Tissue& tissue,
                                                  const std::string& twin,
                                                  const MirrorPlane& plane);

/// The rename of a twin that goes with that of a muscle which keeps it, if the other side's name
/// has one and is free.
/// @param before  the project before the rename
[[nodiscard]] std::optional<model::RenameTissue> twinsRename(const model::Project& before,
                                                             const model::RenameTissue& rename);

/// What has to follow so that muscles that keep their twins (model::Tissue::keepsTwin) are in step
/// again after an act. Empty where none has changed, or where both have.
[[nodiscard]] std::vector<model::Command> twinsFollow(const model::Project& before,
                                                      const model::Project& after,
                                                      const engine::LiveMeshes* meshes,
                                                      const MirrorPlane& plane);

}  // namespace ecorche::studio
