#include <ecorche/engine/picture.h>
#include <ecorche/exchange/medit.h>
#include <ecorche/exchange/model_record.h>
#include <ecorche/exchange/vtu.h>
#include <ecorche/mesh/read_mesh.h>

namespace ecorche::engine {

namespace fs = std::filesystem;

Result<PictureModel> readPictureModel(const fs::path& folder, RunContext& run) {
  auto record = exchange::readModelRecord(folder / "model.json");
  if (!record) return passOn(record);
  const bool haveVtu = fs::exists(folder / "anatomy.vtu");
  auto anatomy = haveVtu ? exchange::readVtu(folder / "anatomy.vtu")
                         : exchange::readMedit(folder / "anatomy.mesh");
  if (!anatomy) return passOn(anatomy);

  PictureModel out;
  const auto load = [&](const std::string& file,
                        const std::string& name) -> Result<PictureModel::Surface> {
    auto mesh = mesh::readMesh(folder / file, {}, run);
    if (!mesh) return passOn(mesh);
    mesh->name = name;
    return PictureModel::Surface{name, std::make_shared<const mesh::SurfaceMesh>(std::move(*mesh)),
                                 nullptr};
  };
  for (const auto& s : record->surfaces) {
    auto surface = load(s.file, s.name);
    if (!surface) return passOn(surface);
    if (s.kind == "skin") {
      out.skin = std::move(*surface);
    } else if (s.kind == "bone") {
      out.bones.push_back(std::move(*surface));
    } else if (s.kind == "obstacle") {
      out.obstacles.push_back(std::move(*surface));
    }
  }
  for (const auto& t : record->tissues) {
    PictureModel::Tissue tissue;
    tissue.id = TissueId(t.id);
    tissue.name = t.name;
    tissue.kind = t.kind;
    for (const auto& curve : t.curves) tissue.curves.push_back(curve.points);
    if (!t.file.empty()) {
      auto surface = load(t.file, t.name);
      if (!surface) return passOn(surface);
      tissue.surface = std::move(*surface);
    }
    out.tissues.push_back(std::move(tissue));
  }
  for (const std::int32_t id : anatomy->tissue) {
    if (id < 1 || id > static_cast<std::int32_t>(out.tissues.size())) {
      return fail(ErrorCode::FileSyntax,
                  "a tet has a tissue that model.json does not list; build again",
                  {.file = (folder / "anatomy.vtu").string()});
    }
    out.label.emplace_back(id);
  }
  out.neighbours =
      std::make_shared<const mesh::TetNeighbours>(mesh::tetAdjacency(anatomy->mesh.T).neighbours);
  out.tets = std::make_shared<const mesh::TetMesh>(std::move(anatomy->mesh));
  return out;
}

}  // namespace ecorche::engine
