#include <ecorche/core/contract.h>
#include <ecorche/render/anatomy_scene.h>
#include <ecorche/render/palette.h>

#include <algorithm>
#include <cmath>

namespace ecorche::render {
namespace {

Rgba ownColour(Material material) {
  switch (material) {
    case Material::Muscle:
      return linearFromOkLab({0.52, 0.125, 0.062});
    case Material::Bone:
      return tint::bone();
    case Material::Skin:
      return tint::skin();
    case Material::Fat:
      return tint::fat();
    case Material::Filler:
      return tint::filler();
    case Material::Obstacle:
      return tint::obstacle();
  }
  return tint::filler();
}

// A cut looks drier and a little darker than the surface.
Rgba cutColour(Material material, const Rgba& colour) {
  OkLab lab = okLabFromLinear(colour);
  lab[0] *= material == Material::Bone ? 0.93 : 0.88;
  return linearFromOkLab(lab);
}

}  // namespace

SurfaceItem surfaceItem(Material material, std::shared_ptr<const mesh::SurfaceMesh> mesh,
                        std::optional<Rgba> colour) {
  EC_REQUIRE(mesh != nullptr);
  SurfaceItem item;
  item.name = mesh->name;
  item.mesh = std::move(mesh);
  item.colour = colour.value_or(ownColour(material));
  item.capped = true;
  item.capColour = cutColour(material, item.colour);
  switch (material) {
    case Material::Muscle:
      item.roughness = 0.36f;
      item.creaseDeg = 75.0;
      item.normalSmoothing = 2;
      break;
    case Material::Bone:
      item.roughness = 0.58f;
      break;
    case Material::Skin:
      item.colour[3] = 0.09f;
      item.edgeOpacity = 0.78f;
      item.roughness = 0.45f;
      item.creaseDeg = 180.0;
      item.cullBack = true;
      item.capped = false;
      break;
    case Material::Fat:
      item.colour[3] = 0.06f;
      item.edgeOpacity = 0.45f;
      item.roughness = 0.4f;
      item.normalSmoothing = 2;
      item.cullBack = true;
      item.capped = false;
      break;
    case Material::Filler:
    case Material::Obstacle:
      item.roughness = 0.55f;
      item.normalSmoothing = 2;
      break;
  }
  return item;
}

LineItem curveItem(const std::vector<mesh::Spline>& curves, const Rgba& colour, double spacing) {
  auto lines = std::make_shared<std::vector<std::vector<mesh::Vector3>>>();
  for (const mesh::Spline& curve : curves) lines->push_back(curve.sample(spacing).point);
  LineItem item;
  item.name = "curves";
  item.lines = lines;
  item.colour = colour;
  item.widthPixels = 3.0f;
  item.onTop = true;
  return item;
}

PointItem controlPointItem(const std::vector<mesh::Spline>& curves, const Rgba& colour) {
  auto points = std::make_shared<std::vector<mesh::Vector3>>();
  for (const mesh::Spline& curve : curves)
    points->insert(points->end(), curve.points().begin(), curve.points().end());
  PointItem item;
  item.name = "control points";
  item.points = points;
  item.colour = colour;
  item.radiusPixels = 4.5f;
  item.onTop = true;
  return item;
}

LineItem fibreItem(const std::vector<std::vector<mesh::Vector3>>& lines, const Rgba& colour,
                   const FibreLineOptions& options) {
  EC_REQUIRE(options.keepEvery > 0);
  auto kept = std::make_shared<std::vector<std::vector<mesh::Vector3>>>();
  auto colours = std::make_shared<std::vector<Rgba>>();
  const OkLab base = okLabFromLinear(colour);
  for (std::size_t i = 0; i < lines.size(); i += options.keepEvery) {
    kept->push_back(lines[i]);
    // Golden-ratio steps: neighbours in the list never get nearly the same lightness
    const double phase = 0.6180339887498949 * static_cast<double>(kept->size());
    const double shift = static_cast<double>(options.contrast) * (phase - std::floor(phase) - 0.5);
    OkLab lab = base;
    lab[0] = std::clamp(base[0] * (1.08 + shift), 0.0, 1.0);
    colours->push_back(linearFromOkLab(lab));
  }
  LineItem item;
  item.name = "fibres";
  item.lines = kept;
  item.lineColours = colours;
  item.colour = colour;
  item.widthPixels = options.widthPixels;
  item.widthMetres = options.widthMetres;
  return item;
}

}  // namespace ecorche::render
