#include <ecorche/core/files.h>
#include <ecorche/model/json.h>
#include <ecorche/model/project_check.h>
#include <ecorche/model/project_file.h>

namespace ecorche::model {

namespace {

// One function per object of the schema; keys in the order of the schema, defaults left out.
class Writer {
 public:
  explicit Writer(const Project& project) : project_(project) {}

  Json project() const {
    Json out = Json::object();
    out.add("schema", Json::number(std::to_string(kSchema)));
    addText(out, "name", project_.name);
    out.add("unit", Json::string(std::string(symbol(project_.unit))));
    out.add("skin", mesh(project_.skin, Json::object()));
    addList(out, "bones", project_.bones, [&](const Bone& bone) {
      return mesh(bone.mesh, Json::object().add("name", Json::string(bone.name)));
    });
    addList(out, "cut_planes", project_.cutPlanes,
            [&](const CutPlane& plane) { return cutPlane(plane); });
    if (Json settings = this->settings(); !settings.items.empty())
      out.add("settings", std::move(settings));
    addList(out, "tissues", project_.tissues,
            [&](const Tissue& tissue) { return this->tissue(tissue); });
    return out;
  }

 private:
  static Json number(double value) { return Json::number(numberText(value)); }
  Json length(double metres) const { return Json::number(lengthText(metres, project_.unit)); }
  Json point(const Vector3& p) const {
    return Json::array({length(p.x()), length(p.y()), length(p.z())});
  }

  static void addText(Json& out, const char* key, std::string_view text) {
    if (!text.empty()) out.add(key, Json::string(std::string(text)));
  }
  template <class Item, class Write>
  static void addList(Json& out, const char* key, const std::vector<Item>& items,
                      const Write& write) {
    if (items.empty()) return;
    Json list = Json::array();
    for (const Item& item : items) list.items.push_back(write(item));
    out.add(key, std::move(list));
  }

  static Json mesh(const MeshRef& mesh, Json out) {
    out.add("file", Json::string(mesh.file));
    addText(out, "part", mesh.part);
    if (mesh.unit) addText(out, "unit", symbol(*mesh.unit));
    if (mesh.repair != mesh::Mending::None) addText(out, "repair", mesh::name(mesh.repair));
    return out;
  }

  Json cutPlane(const CutPlane& plane) const {
    const Vector3& n = plane.normal;
    return Json::object()
        .add("name", Json::string(plane.name))
        .add("kind", Json::string(std::string(word(plane.kind))))
        .add("point", point(plane.point))
        .add("normal", Json::array({number(n.x()), number(n.y()), number(n.z())}));
  }

  Json settings() const {
    const Settings& s = project_.settings;
    const Settings usual;
    Json out = Json::object();
    if (s.fat != usual.fat) out.add("fat", number(s.fat));
    if (s.coreRadius) out.add("core_radius", length(*s.coreRadius));
    if (s.alpha) out.add("alpha", number(*s.alpha));
    if (s.tets) out.add("tets", Json::number(std::to_string(*s.tets)));
    if (s.edgeLength) out.add("edge_length", length(*s.edgeLength));
    if (s.surfaceTolerance != usual.surfaceTolerance)
      out.add("surface_tolerance", number(s.surfaceTolerance));
    return out;
  }

  Json tissue(const Tissue& tissue) const {
    Json out = Json::object();
    out.add("name", Json::string(tissue.name))
        .add("kind", Json::string(std::string(word(tissue.kind))));
    addText(out, "side", word(tissue.side));
    addText(out, "group", tissue.group);
    if (tissue.layer) out.add("layer", Json::number(std::to_string(*tissue.layer)));
    if (tissue.colour) out.add("color", Json::string(colourText(*tissue.colour)));
    if (tissue.isProtected) out.add("protected", Json::truth(true));
    if (tissue.keepsTwin) out.add("keeps_twin", Json::truth(true));
    if (tissue.mesh) out = mesh(*tissue.mesh, std::move(out));
    if (tissue.coreRadius) out.add("core_radius", length(*tissue.coreRadius));
    if (const Anisotropy& a = tissue.anisotropy; a != Anisotropy{}) {
      out.add("anisotropy", Json::object()
                                .add("lambda2", number(a.lambda2))
                                .add("lambda3", number(a.lambda3))
                                .add("rotation", Json::number(angleTextDeg(a.rotation))));
    }
    addList(out, "curves", tissue.curves, [&](const Curve& c) { return curve(c); });
    addList(out, "attachments", tissue.attachments,
            [&](const Attachment& a) { return attachment(a); });
    return out;
  }

  Json curve(const Curve& curve) const {
    Json out = Json::object();
    addText(out, "name", curve.name);
    addList(out, "points", curve.points, [&](const ControlPoint& p) {
      return Json::object().add("at", point(p.at)).add("tissue", number(p.tissue));
    });
    if (curve.start.on != Support::On::Free) out.add("start", support(curve.start, Json::object()));
    if (curve.end.on != Support::On::Free) out.add("end", support(curve.end, Json::object()));
    return out;
  }

  static Json support(const Support& support, Json out) {
    out.add("on", Json::string(std::string(word(support.on))));
    addText(out, "name", support.name);
    return out;
  }

  Json attachment(const Attachment& attachment) const {
    Json out = Json::object();
    addText(out, "role", word(attachment.role));
    out = support(attachment.support, std::move(out));
    if (attachment.at) out.add("at", point(*attachment.at));
    if (attachment.patch) out.add("patch", mesh(*attachment.patch, Json::object()));
    return out;
  }

  const Project& project_;
};

}  // namespace

std::string projectText(const Project& project) { return printJson(Writer(project).project()); }

Result<void> saveProject(const Project& project, const std::filesystem::path& file) {
  if (auto fault = findFault(project)) {
    return fail(fault->code, std::move(fault->message), {.object = std::move(fault->object)});
  }
  return writeFileWhole(file, projectText(project));
}

}  // namespace ecorche::model
