#include <ecorche/core/parallel.h>
#include <ecorche/engine/curve_directions.h>
#include <ecorche/engine/picture.h>
#include <ecorche/model/project_check.h>
#include <ecorche/render/anatomy_scene.h>
#include <ecorche/render/renderer.h>
#include <ecorche/render/slice.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/solve_tissues.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <set>

namespace ecorche::engine {

namespace {

using render::Rgba;

// Which names the user hid or asked for alone
class Visibility {
 public:
  explicit Visibility(const PictureSettings& s)
      : hide_(s.hide.begin(), s.hide.end()), only_(s.only.begin(), s.only.end()) {}

  [[nodiscard]] bool hidden(const std::string& word) const { return hide_.contains(word); }
  [[nodiscard]] bool shows(const std::string& group, const std::string& name) const {
    return !hide_.contains(group) && !hide_.contains(name);
  }
  [[nodiscard]] bool showsTissue(const PictureModel::Tissue& t) const {
    if (!only_.empty()) return only_.contains(t.name);
    return shows(t.kind == "filler" ? "fillers" : "muscles", t.name);
  }
  [[nodiscard]] Result<void> check(const PictureModel& model) const {
    std::set<std::string> known{"skin", "bones", "muscles", "fillers", "curves", "obstacles"};
    for (const auto& b : model.bones) known.insert(b.name);
    for (const auto& t : model.tissues) known.insert(t.name);
    for (const auto* list : {&hide_, &only_}) {
      for (const std::string& word : *list) {
        if (known.contains(word)) continue;
        return fail(ErrorCode::UnknownName,
                    fmt::format("there is no \"{}\" to hide or show; name skin, bones, muscles, "
                                "fillers, curves, or a "
                                "bone or muscle as `ecorche info` lists them",
                                word));
      }
    }
    return {};
  }

 private:
  std::set<std::string> hide_;
  std::set<std::string> only_;
};

std::vector<Rgba> coloursOf(const PictureModel& model, render::Palette palette) {
  // By tissue id; ids 0 and 1 are nothing and fat
  std::vector<std::string> names;
  std::vector<std::optional<Rgba>> fixed;
  for (std::size_t i = 1; i < model.tissues.size(); ++i) {
    names.push_back(model.tissues[i].name);
    fixed.push_back(model.tissues[i].kind == "filler" ? std::optional(render::tint::filler())
                                                      : model.tissues[i].colour);
  }
  const auto touching = render::touchingTissues(model.label, *model.neighbours);
  std::vector<Rgba> out{Rgba{0.5f, 0.5f, 0.5f, 1.0f}, render::tint::fat()};
  const auto chosen = render::tissueColours(static_cast<std::int32_t>(names.size()), touching,
                                            palette, render::sideTwins(names), fixed);
  out.insert(out.end(), chosen.begin(), chosen.end());
  return out;
}

render::SurfaceItem item(render::Material material, const PictureModel::Surface& surface,
                         std::optional<Rgba> colour = std::nullopt) {
  render::SurfaceItem out = render::surfaceItem(material, surface.mesh, colour);
  out.name = surface.name;
  if (surface.normals) out.normals = surface.normals;
  return out;
}

void addTissues(const PictureModel& model, const PictureSettings& settings,
                const Visibility& visible, const std::vector<Rgba>& colours, render::Scene& scene) {
  for (std::size_t i = 1; i < model.tissues.size(); ++i) {
    const PictureModel::Tissue& tissue = model.tissues[i];
    if (!visible.showsTissue(tissue)) continue;
    const Rgba colour = colours[static_cast<std::size_t>(tissue.id.value)];
    if (settings.fibers && tissue.kind == "muscle" && !model.volume) {
      if (!tissue.fibers.empty())
        scene.lines.push_back(render::fibreItem(tissue.fibers, colour, {.widthPixels = 2.0f}));
    } else if (tissue.surface.mesh && !tissue.surface.mesh->empty()) {
      scene.surfaces.push_back(
          item(tissue.kind == "filler" ? render::Material::Filler : render::Material::Muscle,
               tissue.surface, colour));
    }
    if (settings.curves && visible.shows("curves", "curves")) {
      render::LineItem line;
      line.name = tissue.name;
      line.lines = std::make_shared<const std::vector<std::vector<mesh::Vector3>>>(tissue.curves);
      line.colour = render::tint::curve();
      line.widthPixels = 2.5f;
      line.onTop = true;
      scene.lines.push_back(std::move(line));
    }
  }
  if (settings.curves && visible.shows("curves", "curves") && !model.controlPoints.empty()) {
    render::PointItem points;
    points.name = "control points";
    points.points = std::make_shared<const std::vector<mesh::Vector3>>(model.controlPoints);
    points.onTop = true;
    scene.points.push_back(std::move(points));
  }
}

void addVolume(const PictureModel& model, const PictureSettings& settings,
               const Visibility& visible, const std::vector<Rgba>& colours, render::Scene& scene) {
  scene.volume = model.volume;
  if (!settings.fibers) scene.volume->flow = nullptr;
  for (std::size_t i = 0; i < model.tissues.size(); ++i) {
    const PictureModel::Tissue& tissue = model.tissues[i];
    render::VolumeTissue& look = scene.volume->tissues[i];
    look.colour = colours[static_cast<std::size_t>(tissue.id.value)];
    const bool fat = tissue.kind == "fat";
    look.visible = !fat && visible.showsTissue(tissue);
    look.inCut = fat ? !visible.hidden("fat") : look.visible;
    look.roughness = tissue.kind == "filler" ? 0.55f : 0.36f;
  }
}

void addSlice(const PictureModel& model, const PictureSettings& settings, const Visibility& visible,
              const std::vector<Rgba>& colours, render::Scene& scene) {
  if (!model.tets || model.tets->T.rows() == 0) return;
  std::vector<TissueId> label = model.label;
  // What the user hid is not in the cut either
  std::vector<std::uint8_t> shown(colours.size(), 1);
  for (const auto& t : model.tissues) {
    const bool fat = t.kind == "fat";
    shown[static_cast<std::size_t>(t.id.value)] =
        fat ? !visible.hidden("fat") : visible.showsTissue(t);
  }
  mesh::TetMesh kept;
  std::vector<Eigen::Index> rows;
  for (Eigen::Index t = 0; t < model.tets->T.rows(); ++t) {
    if (shown[static_cast<std::size_t>(label[static_cast<std::size_t>(t)].value)] != 0)
      rows.push_back(t);
  }
  const bool all = static_cast<Eigen::Index>(rows.size()) == model.tets->T.rows();
  mesh::TetNeighbours neighbours;
  if (!all) {
    kept.V = model.tets->V;
    kept.T.resize(static_cast<Eigen::Index>(rows.size()), 4);
    std::vector<TissueId> fewer;
    for (std::size_t r = 0; r < rows.size(); ++r) {
      kept.T.row(static_cast<Eigen::Index>(r)) = model.tets->T.row(rows[r]);
      fewer.push_back(label[static_cast<std::size_t>(rows[r])]);
    }
    label = std::move(fewer);
    neighbours = mesh::tetAdjacency(kept.T).neighbours;
  }
  const render::TetSlice slice = render::sliceTets(
      all ? *model.tets : kept, label, all ? *model.neighbours : neighbours, *settings.clip);
  scene.surfaces.push_back(render::sliceItem(slice, colours));
  scene.lines.push_back(render::sliceBorders(slice));
}

}  // namespace

namespace {

PictureModel::Surface pictureSurface(const mesh::SurfaceMesh& mesh) {
  return {mesh.name, std::make_shared<const mesh::SurfaceMesh>(mesh), nullptr};
}

// Name, kind, colour and curves of a muscle or filler; its control points join the model's
PictureModel::Tissue pictureTissue(const model::Tissue& from, const tissue::CurveTissue& curves,
                                   TissueId id, double spacing, PictureModel& model) {
  PictureModel::Tissue tissue;
  tissue.id = id;
  tissue.name = curves.name;
  tissue.kind = std::string(model::word(from.kind));
  if (from.colour) tissue.colour = render::colourFromHex(model::colourText(*from.colour));
  for (const auto& curve : curves.curves)
    tissue.curves.push_back(curve.spline.sample(spacing).point);
  for (const auto& curve : from.curves) {
    for (const auto& point : curve.points) model.controlPoints.push_back(point.at);
  }
  return tissue;
}

}  // namespace

namespace {}  // namespace

Result<Preview> preparePreview(const model::Project& project, const BuildOptions& options,
                               RunContext& run) {
  if (auto sound = model::checkProject(project); !sound) return passOn(sound);
  auto domain = prepareDomain(project, options, run);
  if (!domain) return passOn(domain);
  auto solved = tissue::solveTissues(domain->build.domain, curveTissues(project),
                                     tissueOptions(project), run);
  if (!solved) return passOn(solved);
  return Preview{std::move(*domain), std::move(solved->fields)};
}

PictureModel pictureModel(const model::Project& project, const Preview& preview) {
  PictureModel out;
  const domain::Domain& domain = preview.domain.build.domain;
  out.skin = pictureSurface(preview.domain.meshes.skin);
  for (const auto& m : preview.domain.meshes.bones) out.bones.push_back(pictureSurface(m));
  for (const auto& m : preview.domain.meshes.obstacles) out.obstacles.push_back(pictureSurface(m));
  const std::vector<tissue::CurveTissue> tissues = curveTissues(project);
  const std::vector<std::size_t> places = curveTissuePlaces(project);
  out.tissues.push_back({.id = kFat, .name = "fat", .kind = "fat"});
  for (std::size_t i = 0; i < tissues.size(); ++i)
    out.tissues.push_back(pictureTissue(project.tissues[places[i]], tissues[i],
                                        TissueId(static_cast<std::int64_t>(i) + 2),
                                        0.002 * domain.skinDiagonal, out));
  out.tets = std::make_shared<const mesh::TetMesh>(domain.mesh);
  out.neighbours = std::make_shared<const mesh::TetNeighbours>(domain.neighbours);
  // For telling neighbours apart by colour the owner of a corner is enough
  const std::vector<TissueId> owner = tissue::vertexOwners(preview.fields);
  for (Eigen::Index t = 0; t < domain.mesh.T.rows(); ++t)
    out.label.push_back(owner[static_cast<std::size_t>(domain.mesh.T(t, 0))]);
  render::VolumeItem volume;
  volume.geometry = std::make_shared<const render::VolumeGeometry>(out.tets, domain.neighbours);
  volume.fields = std::make_shared<const tissue::FieldMatrix>(preview.fields.values);
  volume.fatIsCandidate = preview.fields.fatIsCandidate;
  volume.tissues.resize(out.tissues.size());
  std::vector<std::vector<std::vector<mesh::Vector3>>> lines;
  for (const PictureModel::Tissue& tissue : out.tissues) {
    lines.emplace_back();
    if (tissue.kind == "muscle") lines.back() = tissue.curves;
  }
  volume.flow = curveDirections(domain.mesh.V, owner, lines);
  out.volume = std::move(volume);
  return out;
}

PictureModel pictureModel(const model::Project& project, const Build& build) {
  PictureModel out;
  out.skin = pictureSurface(build.meshes.skin);
  for (const auto& m : build.meshes.bones) out.bones.push_back(pictureSurface(m));
  for (const auto& m : build.meshes.obstacles) out.obstacles.push_back(pictureSurface(m));
  const std::vector<std::size_t> places = curveTissuePlaces(project);
  const double spacing = 0.002 * build.domain.domain.skinDiagonal;
  for (std::size_t i = 0; i < build.surfaces.size(); ++i) {
    const TissueId id(static_cast<std::int64_t>(i) + 1);
    PictureModel::Tissue tissue{.id = id, .name = build.surfaces[i].mesh.name, .kind = "fat"};
    if (i > 0)
      tissue =
          pictureTissue(project.tissues[places[i - 1]], build.tissues[i - 1], id, spacing, out);
    tissue.surface = pictureSurface(build.surfaces[i].mesh);
    if (i > 0) {
      tissue.surface.normals = std::make_shared<const mesh::Directions>(envelope::fieldNormals(
          build.surfaces[i], build.anatomy, build.domain.domain, build.fields));
      for (const auto& muscle : build.fibers.muscles) {
        if (muscle.tissue == tissue.id) tissue.fibers = muscle.lines;
      }
    }
    out.tissues.push_back(std::move(tissue));
  }
  out.tets = std::make_shared<const mesh::TetMesh>(build.anatomy.mesh);
  out.neighbours = std::make_shared<const mesh::TetNeighbours>(build.anatomy.neighbours);
  out.label = build.anatomy.label;
  return out;
}

Result<render::ClipPlane> parseClip(const std::string& text) {
  const auto refuse = [&] {
    return fail(
        ErrorCode::CommandSyntax,
        fmt::format(
            "\"{}\" is no clip plane; write x=0.1, y<0.2 (keep what is below) or z>0, in metres",
            text));
  };
  if (text.size() < 3) return refuse();
  const int axis = text[0] == 'x' ? 0 : text[0] == 'y' ? 1 : text[0] == 'z' ? 2 : -1;
  const bool below = text[1] == '<';
  if (axis < 0 || (text[1] != '=' && text[1] != '>' && !below)) return refuse();
  double value = 0.0;
  const auto [end, ec] = std::from_chars(text.data() + 2, text.data() + text.size(), value);
  if (ec != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
    return refuse();
  render::ClipPlane plane;
  plane.point[axis] = value;
  plane.normal = mesh::Vector3::Zero();
  plane.normal[axis] = below ? -1.0 : 1.0;
  return plane;
}

Result<render::Image> drawPicture(const PictureModel& model, const PictureSettings& settings,
                                  RunContext& run) {
  const Visibility visible(settings);
  if (auto known = visible.check(model); !known) return passOn(known);
  auto view = render::parseView(settings.view);
  if (!view) return passOn(view);

  render::Scene scene;
  if (settings.transparentBackground) scene.background = {1.0f, 1.0f, 1.0f, 0.0f};
  const std::vector<Rgba> colours = coloursOf(model, settings.palette);
  if (visible.shows("skin", "skin") && model.skin.mesh) {
    scene.surfaces.push_back(item(render::Material::Skin, model.skin));
  }
  for (const auto& bone : model.bones) {
    if (visible.shows("bones", bone.name))
      scene.surfaces.push_back(item(render::Material::Bone, bone));
  }
  for (const auto& obstacle : model.obstacles) {
    if (visible.shows("obstacles", obstacle.name))
      scene.surfaces.push_back(item(render::Material::Obstacle, obstacle));
  }
  addTissues(model, settings, visible, colours, scene);
  if (model.volume) addVolume(model, settings, visible, colours, scene);
  if (settings.clip) {
    scene.clip = settings.clip;
    if (!model.volume) addSlice(model, settings, visible, colours, scene);
  }

  // Framed on what is seen of the domain: half models and regions fill the picture although skin
  // and bones are whole
  const mesh::Box box = model.tets && model.tets->V.rows() > 0
                            ? mesh::boundingBox(model.tets->V)
                            : mesh::boundingBox(*model.skin.mesh);
  const mesh::Box whole = mesh::boundingBox(*model.skin.mesh);
  const render::ModelAxes axes = render::guessedAxes(whole, settings.up);
  const double aspect = static_cast<double>(settings.width) / settings.height;
  const render::Camera camera = render::framed(*view, axes, scene, aspect, 0.03, box);
  render::PictureOptions how;
  how.width = settings.width;
  how.height = settings.height;
  how.samples = settings.samples;
  how.motion = settings.motion;
  return render::renderPicture(scene, camera, how, run);
}

Result<render::Image> drawPicture(const model::Project& project, const Build& build,
                                  const PictureSettings& settings, RunContext& run) {
  return drawPicture(pictureModel(project, build), settings, run);
}

}  // namespace ecorche::engine
