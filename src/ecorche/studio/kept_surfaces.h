#pragma once

#include <ecorche/domain/build_domain.h>
#include <ecorche/engine/live_engine.h>

#include <memory>
#include <vector>

namespace ecorche::studio {

/// Skin and bones as far as cut planes leave them: what lies beyond is not part of the model.
struct KeptSurfaces {
  std::shared_ptr<const mesh::SurfaceMesh> skin;
  bool resampled = false;  ///< the skin is the domain's own, which is open at the planes
  std::vector<std::shared_ptr<const mesh::SurfaceMesh>>
      bones;  ///< those of which something is left
};

/// Originals where planes leave them whole; the domain's own faces where planes cut them.
/// @param domain  may be null: everything as it came
[[nodiscard]] KeptSurfaces keptSurfaces(const std::shared_ptr<const engine::LiveMeshes>& meshes,
                                        const std::vector<model::CutPlane>& planes,
                                        const std::shared_ptr<const domain::DomainBuild>& domain);

}  // namespace ecorche::studio
