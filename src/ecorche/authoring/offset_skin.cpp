#include <ecorche/authoring/offset_skin.h>
#include <ecorche/mesh/surface_topology.h>
#include <ecorche/mesh/surface_wrap.h>
#include <fmt/format.h>

#include <algorithm>

namespace ecorche::authoring {

Result<mesh::SurfaceMesh> offsetSkin(const std::vector<mesh::SurfaceMesh>& bones, double distance,
                                     RunContext& run) {
  const Stage stage(run, "skin around bones");
  for (const mesh::SurfaceMesh& bone : bones) {
    if (bone.V.allFinite()) continue;
    return fail(ErrorCode::NonFiniteVertex,
                fmt::format("\"{}\" has a vertex that is no number, so no skin can be laid around "
                            "it; export it again from where it was made",
                            bone.name),
                {.object = bone.name});
  }
  const mesh::SurfaceMesh all = mesh::joined(bones, "skin");
  const double diagonal = mesh::boundingBox(all).diagonal();
  // Wide enough to lie smoothly over single bones; wider where bones stand so far apart that each
  // got a skin of its own. In the end the wrap is the convex hull's, and that is one piece.
  for (double gap = std::max(2.0 * distance, 0.04 * diagonal);; gap *= 2.0) {
    auto skin = mesh::wrapSurface(all, gap, distance, run);
    if (!skin || mesh::components(skin->F).count == 1 || gap > 2.0 * diagonal) return skin;
  }
}

}  // namespace ecorche::authoring
