#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/mesh/tet_mesh.h>
#include <ecorche/render/scene.h>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ecorche::render {

/// Lightness in [0, 1] and two opponent axes; equal distances look about equally different
/// [Ottosson 2020, OKLab].
using OkLab = std::array<double, 3>;
[[nodiscard]] OkLab okLabFromLinear(const Rgba& linear);
/// Clamped to what a screen shows; opaque.
[[nodiscard]] Rgba linearFromOkLab(const OkLab& lab);

/// How different two colours look [OKLab units; 0.02 is just noticed], also to eyes without the red
/// or the green cones [Machado, Oliveira, Fernandes 2009]: the smaller of the plain distance
/// and 1.6 times the distance they see.
[[nodiscard]] double colourDistance(const Rgba& a, const Rgba& b);

/// "#c0504d" as linear light, opaque; nothing where the text is no colour.
[[nodiscard]] std::optional<Rgba> colourFromHex(std::string_view text);
[[nodiscard]] std::string hexFromColour(const Rgba& linear);

/// Things that keep their colour in every picture.
namespace tint {
[[nodiscard]] Rgba bone();
[[nodiscard]] Rgba fat();
[[nodiscard]] Rgba skin();
[[nodiscard]] Rgba filler();
[[nodiscard]] Rgba obstacle();
[[nodiscard]] Rgba curve();
}  // namespace tint

enum class Palette {
  Anatomical,  ///< flesh: reds, terracotta, ochre, rose, plum
  Distinct     ///< all hues, for telling tissues apart
};

using NeighbourPairs = std::vector<std::pair<std::int32_t, std::int32_t>>;

/// Colours for `count` tissues such that neighbours look different; the same answer every time.
///
/// Greedy: tissues with most neighbours first, each takes the colour that is farthest from its
/// coloured neighbours, among nearly equal ones the one used least.
///
/// @param neighbours  pairs of tissues that touch, in any order
/// @param twin        #count or empty: tissue that this one shares its colour with (left and
/// right), -1: none
/// @param fixed       #count or empty: colours that were chosen by somebody; others keep away from
/// them
[[nodiscard]] std::vector<Rgba> tissueColours(std::int32_t count, const NeighbourPairs& neighbours,
                                              Palette palette = Palette::Anatomical,
                                              const std::vector<std::int32_t>& twin = {},
                                              const std::vector<std::optional<Rgba>>& fixed = {});

/// Tissues that share a face, as pairs of label − firstLabel; labels below it are left out.
[[nodiscard]] NeighbourPairs touchingTissues(const std::vector<TissueId>& label,
                                             const mesh::TetNeighbours& neighbours,
                                             TissueId firstLabel = kFirstMuscle);

/// Surfaces with vertices in the same or in adjacent cells of a grid of `distance` [m].
[[nodiscard]] NeighbourPairs nearSurfaces(const std::vector<const mesh::SurfaceMesh*>& meshes,
                                          double distance);

/// For names that differ in a side only ("soleus_L", "left soleus"): the first of each such group,
/// -1 for itself.
[[nodiscard]] std::vector<std::int32_t> sideTwins(const std::vector<std::string>& names);

}  // namespace ecorche::render
