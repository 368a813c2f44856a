#include <ecorche/domain/carve.h>
#include <ecorche/domain/wrap.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/surface_wrap.h>

namespace ecorche::domain {

Result<TaggedSurface> wrap(const std::vector<const Hole*>& holes, double tolerance,
                           RunContext& run) {
  std::vector<mesh::SurfaceMesh> meshes;
  std::vector<std::int32_t> tags;
  for (const Hole* hole : holes) {
    meshes.push_back(hole->mesh);
    tags.insert(tags.end(), static_cast<std::size_t>(hole->mesh.F.rows()), packed(hole->tag));
  }
  const mesh::SurfaceMesh all = mesh::joined(meshes, holes.front()->name);
  auto wrapped = mesh::wrapSurface(all, tolerance, tolerance / 3.0, run);
  if (!wrapped) return passOn(wrapped);

  const mesh::SurfaceQuery query(all);
  TaggedSurface out{std::move(wrapped->V), std::move(wrapped->F), {}};
  for (Eigen::Index f = 0; f < out.F.rows(); ++f) {
    const mesh::Vector3 middle =
        (out.V.row(out.F(f, 0)) + out.V.row(out.F(f, 1)) + out.V.row(out.F(f, 2))).transpose() /
        3.0;
    out.tag.push_back(tags[static_cast<std::size_t>(query.closest(middle).face)]);
  }
  return out;
}

}  // namespace ecorche::domain
