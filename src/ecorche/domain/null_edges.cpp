#include <ecorche/domain/half_edges.h>
#include <ecorche/domain/null_edges.h>

namespace ecorche::domain {

TaggedSurface withoutNullEdges(const TaggedSurface& surface) {
  auto built = HalfEdges::build(surface);
  if (!built) return surface;
  HalfEdges& he = *built;
  bool changed = false;
  for (std::int32_t h = 0; h < he.halfEdgeCount(); h += 2) {
    if (!he.edgeAlive(h) || surface.V.row(he.from(h)) != surface.V.row(he.to(h))) continue;
    if (!he.canCollapse(h)) continue;
    he.collapse(h);
    changed = true;
  }
  if (!changed) return surface;
  std::vector<mesh::Vector3> positions;
  for (Eigen::Index v = 0; v < surface.V.rows(); ++v)
    positions.push_back(surface.V.row(v).transpose());
  return he.toSurface(positions);
}

}  // namespace ecorche::domain
