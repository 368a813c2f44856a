#include <ecorche/engine/live_parts.h>
#include <ecorche/render/anatomy_scene.h>
#include <ecorche/studio/scene_builder.h>
#include <ecorche/studio/volume_look.h>

#include <algorithm>

namespace ecorche::studio {

using mesh::Vector3;
using render::Rgba;

namespace {

constexpr float kCurveWidth = 2.0f;     // [pixels]
constexpr float kSelectedWidth = 3.2f;  // [pixels]
constexpr float kPointRadius = 5.5f;    // [pixels]
constexpr double kCurveSteps = 400.0;   // of a diagonal

// Towards white, in linear light
Rgba lifted(const Rgba& c, float share) {
  return {c[0] + share * (1.0f - c[0]), c[1] + share * (1.0f - c[1]), c[2] + share * (1.0f - c[2]),
          c[3]};
}

std::vector<Vector3> polyline(const model::Curve& curve, double spacing) {
  return model::splineOf(curve).sample(spacing).point;
}

render::LineItem line(std::vector<std::vector<Vector3>> lines, const Rgba& colour, float width) {
  render::LineItem out;
  out.lines = std::make_shared<const std::vector<std::vector<Vector3>>>(std::move(lines));
  out.colour = colour;
  out.widthPixels = width;
  out.onTop = true;
  return out;
}

render::PointItem balls(std::vector<Vector3> points, const Rgba& colour, float radius) {
  render::PointItem out;
  out.points = std::make_shared<const std::vector<Vector3>>(std::move(points));
  out.colour = colour;
  out.radiusPixels = radius;
  out.onTop = true;
  return out;
}

}  // namespace

void SceneBuilder::takeMeshes(const Input& input) {
  if (input.meshes == meshesSeen_ && input.domain == domainSeen_ &&
      input.project.cutPlanes == planesSeen_)
    return;
  meshesSeen_ = input.meshes;
  domainSeen_ = input.domain;
  planesSeen_ = input.project.cutPlanes;
  kept_ = input.meshes ? keptSurfaces(input.meshes, planesSeen_, input.domain) : KeptSurfaces{};
}

const std::vector<Rgba>& SceneBuilder::tissueColours(
    const model::Project& project, const std::shared_ptr<const engine::LiveTissues>& tissues,
    render::Palette palette) {
  std::vector<std::string> names;
  std::vector<std::optional<model::Colour>> chosen;
  for (const model::Tissue& t : project.tissues) {
    names.push_back(t.name);
    chosen.push_back(t.kind == model::Tissue::Kind::Filler ? model::Colour{150, 130, 110}
                                                           : t.colour);
  }
  if (tissues == colouredFor_ && names == colouredNames_ && chosen == colouredFixed_ &&
      palette == colouredPalette_)
    return colours_;

  std::vector<std::optional<Rgba>> fixed;
  for (const auto& c : chosen)
    fixed.push_back(c ? render::colourFromHex(model::colourText(*c)) : std::nullopt);
  render::NeighbourPairs touching;
  if (tissues) {
    const auto places = engine::liveTissuePlaces(project);
    const auto placeOf = [&](std::int32_t entry) -> std::int32_t {
      const std::size_t slot = tissues->slotOf[static_cast<std::size_t>(entry)];
      return slot < places.size() ? static_cast<std::int32_t>(places[slot]) : -1;
    };
    for (const auto& [a, b] : tissues->touching) {
      if (placeOf(a) >= 0 && placeOf(b) >= 0) touching.emplace_back(placeOf(a), placeOf(b));
    }
  }
  colours_ = render::tissueColours(static_cast<std::int32_t>(names.size()), touching, palette,
                                   render::sideTwins(names), fixed);
  colouredFor_ = tissues;
  colouredNames_ = std::move(names);
  colouredFixed_ = std::move(chosen);
  colouredPalette_ = palette;
  return colours_;
}

void SceneBuilder::addVolume(const Input& input, render::Scene& scene) {
  if (!input.tissues) return;
  scene.volume = volumeOf(input.project, *input.tissues, input.display,
                          tissueColours(input.project, input.tissues, input.display.palette));
  scene.volume->fieldsRevision = input.edits.revision;
  scene.volume->changed = input.edits.changed;
  scene.volume->prepared = input.edits.prepared;
  scene.volume->flow = input.flow;
  const auto places = engine::liveTissuePlaces(input.project);
  for (std::size_t i = 0; i < input.tissues->slotOf.size(); ++i) {
    if (input.tissues->slotOf[i] >= places.size()) continue;
    const std::string& name = input.project.tissues[places[input.tissues->slotOf[i]]].name;
    const float lift = name == input.selection.tissue ? 0.12f
                       : name == input.hovered.tissue ? 0.06f
                                                      : 0.0f;
    auto& colour = scene.volume->tissues[i + 1].colour;
    colour = lifted(colour, lift);
  }
}

// Lines keep their address while no curve and no colour changes: turning the eye sends nothing.
void SceneBuilder::addLines(const Input& input, const SceneColours& colours, render::Scene& scene) {
  CurvesShown wanted;
  std::vector<const model::Curve*> others, own;
  wanted.spacing = (input.meshes ? input.meshes->diagonal : 1.0) / kCurveSteps;
  for (const model::Tissue& tissue : input.project.tissues) {
    const bool selected = tissue.name == input.selection.tissue;
    if (!selected && (!input.display.allCurves || !input.display.showsTissue(tissue.name)))
      continue;
    for (const model::Curve& curve : tissue.curves) {
      (selected ? own : others).push_back(&curve);
      auto& points = (selected ? wanted.own : wanted.others).emplace_back();
      for (const auto& point : curve.points) points.push_back(point.at);
    }
  }
  wanted.pixelScale = input.pixelScale;
  wanted.colour = colours.curve;
  wanted.accent = colours.accent;
  if (!(wanted == curvesShown_)) {
    lines_.clear();
    const auto add = [&](const std::vector<const model::Curve*>& curves, const Rgba& colour,
                         float width) {
      if (curves.empty()) return;
      std::vector<std::vector<Vector3>> sampled;
      for (const model::Curve* curve : curves) sampled.push_back(polyline(*curve, wanted.spacing));
      lines_.push_back(line(std::move(sampled), colour, width));
    };
    const auto scale = static_cast<float>(input.pixelScale);
    add(others, colours.curve, scale * kCurveWidth);
    add(own, colours.accent, scale * kSelectedWidth);
    curvesShown_ = std::move(wanted);
  }
  scene.lines = lines_;
}

void SceneBuilder::addPoints(const Input& input, const SceneColours& colours,
                             render::Scene& scene) {
  const float radius = static_cast<float>(input.pixelScale) * kPointRadius;
  if (const auto place = model::findTissue(input.project, input.selection.tissue)) {
    const model::Tissue& tissue = input.project.tissues[*place];
    std::vector<Vector3> plain;
    std::vector<Vector3> taken;
    for (std::size_t c = 0; c < tissue.curves.size(); ++c) {
      for (std::size_t p = 0; p < tissue.curves[c].points.size(); ++p) {
        const auto is = [&](const Selection& s) {
          return s.tissue == tissue.name && s.curve == static_cast<int>(c) &&
                 s.point == static_cast<int>(p);
        };
        (is(input.selection) || is(input.hovered) ? taken : plain)
            .push_back(tissue.curves[c].points[p].at);
      }
    }
    const Rgba white{0.95f, 0.95f, 0.93f, 1.0f};
    if (!plain.empty()) scene.points.push_back(balls(std::move(plain), white, radius));
    if (!taken.empty())
      scene.points.push_back(balls(std::move(taken), colours.accent, 1.25f * radius));
  }
  if (!input.marks.empty()) scene.points.push_back(balls(input.marks, colours.accent, radius));
}

render::Scene SceneBuilder::build(const Input& input, const SceneColours& colours) {
  takeMeshes(input);
  render::Scene scene;
  scene.background = colours.background;
  scene.clip = input.display.clip;
  const auto& skin = kept_.skin;
  if (skin && input.display.skin && input.display.skinOpacity > 0.0 && skin->F.rows() > 0) {
    render::SurfaceItem item = render::surfaceItem(render::Material::Skin, skin);
    if (kept_.resampled) item.normalSmoothing = std::max(item.normalSmoothing, 3);
    const auto share = static_cast<float>(input.display.skinOpacity / 0.35);
    item.colour[3] = std::min(0.98f, item.colour[3] * share);
    if (item.edgeOpacity) item.edgeOpacity = std::min(0.98f, *item.edgeOpacity * share);
    scene.surfaces.push_back(std::move(item));
  }
  for (const auto& bone : kept_.bones) {
    if (!input.display.showsBone(bone->name) || bone->F.rows() == 0) continue;
    render::SurfaceItem item = render::surfaceItem(render::Material::Bone, bone);
    item.name = bone->name;
    if (bone->name == input.selection.bone || bone->name == input.hovered.bone)
      item.colour = lifted(item.colour, 0.3f);
    scene.surfaces.push_back(std::move(item));
  }
  addVolume(input, scene);
  addLines(input, colours, scene);
  addPoints(input, colours, scene);
  const auto scale = static_cast<float>(input.pixelScale);
  if (input.stroke.size() >= 2)
    scene.lines.push_back(line({input.stroke}, colours.accent, scale * kSelectedWidth));
  if (!input.guides.empty())
    scene.lines.push_back(line(input.guides, colours.accent, scale * kCurveWidth));
  return scene;
}

}  // namespace ecorche::studio
