#pragma once

#include <ecorche/core/finding.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>
#include <ecorche/engine/inputs.h>

#include <cstdint>
#include <string>
#include <vector>

namespace ecorche::engine {

/// What a mesh is meant for decides what may be wrong with it.
enum class MeshRole { Skin, Bone, Obstacle, Cavity, Unknown };
[[nodiscard]] const char* name(MeshRole role);

/// One mesh as it came, and what is to be said about it.
struct MeshLook {
  std::string name;
  MeshRole role = MeshRole::Unknown;
  std::int64_t vertices = 0;
  std::int64_t faces = 0;
  std::int64_t pieces = 0;
  bool closed = false;
  double size = 0.0;    ///< of its box, corner to corner [m]
  double volume = 0.0;  ///< [m³]; of no meaning where not closed
  /// Each with what `build` does about it, or what the user can (Finding::remedy). Errors are what
  /// `build` refuses.
  Findings findings;
};

/// Everything that is to be said about meshes before anything is made of them: for a table, for
/// JSON, and for a window that lists places to fly to.
struct ImportCheck {
  std::vector<MeshLook> meshes;  ///< skin, bones, obstacles, cavities
  Findings between;  ///< units, overlaps, contacts, what pokes out: of two meshes or more

  [[nodiscard]] std::int64_t count(Severity severity) const;
};

/// Looks at one mesh alone; nothing is known of its role unless given.
/// @errors Cancelled
[[nodiscard]] Result<MeshLook> lookAtMesh(const mesh::SurfaceMesh& mesh, MeshRole role,
                                          RunContext& run);

/// Looks at every mesh and at what stands between them.
/// @param cutPlanes  what they cut away is not looked at where it reaches out of the skin
/// @param tolerance   how near two bones may come without being told [share of the skin's diagonal]
/// @errors Cancelled
[[nodiscard]] Result<ImportCheck> checkImport(const ProjectMeshes& meshes,
                                              const std::vector<domain::CutPlane>& cutPlanes,
                                              double tolerance, RunContext& run);

}  // namespace ecorche::engine
