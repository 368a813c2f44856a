#pragma once

#include <ecorche/mesh/spline.h>
#include <ecorche/render/renderer.h>
#include <ecorche/render/scene.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::render {

/// What a surface is made of: decides colour, gloss, transparency and smoothing of its item.
enum class Material {
  Muscle,
  Bone,
  Skin,  ///< transparent, denser where it turns away from the eye
  Fat,   ///< transparent, thinner than skin
  Filler,
  Obstacle
};

/// A surface as an item that looks like what it is. Closed ones are drawn massive where a clip
/// plane cuts them.
/// @param colour  unset: the material's own (for muscles a flesh red; see tissueColours for one
/// each)
[[nodiscard]] SurfaceItem surfaceItem(Material material,
                                      std::shared_ptr<const mesh::SurfaceMesh> mesh,
                                      std::optional<Rgba> colour = std::nullopt);

/// Drawn curves of muscles as dark tubes through everything.
[[nodiscard]] LineItem curveItem(const std::vector<mesh::Spline>& curves, const Rgba& colour,
                                 double spacing);
/// Control points as balls through everything.
[[nodiscard]] PointItem controlPointItem(const std::vector<mesh::Spline>& curves,
                                         const Rgba& colour);

struct FibreLineOptions {
  double widthMetres = 0.0;  ///< 0: widthPixels
  float widthPixels = 1.6f;
  float contrast =
      0.35f;  ///< how much lines differ in lightness among themselves, so that each can be followed
  std::size_t keepEvery = 1;  ///< draw one line in so many
};

/// Traced fibres as thin tubes in the muscle's colour, each a little lighter or darker than the
/// next.
[[nodiscard]] LineItem fibreItem(const std::vector<std::vector<mesh::Vector3>>& lines,
                                 const Rgba& colour, const FibreLineOptions& options = {});

}  // namespace ecorche::render
