#include <ecorche/studio/kept_surfaces.h>

#include <algorithm>
#include <unordered_map>

namespace ecorche::studio {

using domain::BoundaryTag;

namespace {

enum class Side { Kept, Cut, Gone };

Side sideOf(const mesh::SurfaceMesh& mesh, const std::vector<model::CutPlane>& planes) {
  bool cut = false;
  for (const model::CutPlane& plane : planes) {
    const Eigen::VectorXd height = (mesh.V.rowwise() - plane.point.transpose()) * plane.normal;
    if (height.maxCoeff() <= 0.0) return Side::Gone;
    cut = cut || height.minCoeff() < 0.0;
  }
  return cut ? Side::Cut : Side::Kept;
}

std::shared_ptr<const mesh::SurfaceMesh> facesOf(const domain::Domain& domain, BoundaryTag tag,
                                                 const std::string& name) {
  auto out = std::make_shared<mesh::SurfaceMesh>();
  out->name = name;
  std::vector<Eigen::Index> rows;
  for (std::size_t f = 0; f < domain.boundaryTag.size(); ++f) {
    if (domain.boundaryTag[f] == tag) rows.push_back(static_cast<Eigen::Index>(f));
  }
  std::unordered_map<std::int32_t, std::int32_t> own;
  std::vector<std::int32_t> vertex;
  out->F.resize(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t v = domain.boundaryF(rows[r], k);
      const auto [at, isNew] = own.try_emplace(v, static_cast<std::int32_t>(vertex.size()));
      if (isNew) vertex.push_back(v);
      out->F(static_cast<Eigen::Index>(r), k) = at->second;
    }
  }
  out->V.resize(static_cast<Eigen::Index>(vertex.size()), 3);
  for (std::size_t v = 0; v < vertex.size(); ++v)
    out->V.row(static_cast<Eigen::Index>(v)) = domain.mesh.V.row(vertex[v]);
  return out;
}

}  // namespace

KeptSurfaces keptSurfaces(const std::shared_ptr<const engine::LiveMeshes>& meshes,
                          const std::vector<model::CutPlane>& planes,
                          const std::shared_ptr<const domain::DomainBuild>& domain) {
  KeptSurfaces out;
  // Shared with the session's own copy, which lives as long
  const auto shared = [&](const mesh::SurfaceMesh& mesh) {
    return std::shared_ptr<const mesh::SurfaceMesh>(meshes, &mesh);
  };
  const mesh::SurfaceMesh& skin = meshes->meshes.skin;
  const bool planesCount = domain && !planes.empty();
  out.resampled = planesCount && skin.V.rows() > 0 && sideOf(skin, planes) != Side::Kept;
  out.skin = out.resampled ? facesOf(domain->domain, {BoundaryTag::Kind::Skin, 0}, skin.name)
                           : shared(skin);
  for (std::size_t b = 0; b < meshes->meshes.bones.size(); ++b) {
    const mesh::SurfaceMesh& bone = meshes->meshes.bones[b];
    if (bone.F.rows() == 0) continue;
    const Side side = planesCount ? sideOf(bone, planes) : Side::Kept;
    if (side == Side::Gone) continue;
    auto kept = side == Side::Kept
                    ? shared(bone)
                    : facesOf(domain->domain,
                              {BoundaryTag::Kind::Bone, static_cast<std::int32_t>(b)}, bone.name);
    if (kept->F.rows() > 0) out.bones.push_back(std::move(kept));
  }
  return out;
}

}  // namespace ecorche::studio
