#pragma once

// Private to render's sources: GLSL 3.30 texts, complete with their #version line.

#include <string>

namespace ecorche::render::glsl {

/// Directions a shader can take at most in one pass.
inline constexpr int kMaxLights = 16;

/// Lamps of a pass and the highlight they make, for other shaders to use.
[[nodiscard]] std::string lightFunctions();

/// Vertex shaders. Positions are relative to the scene's middle, in metres.
[[nodiscard]] std::string meshVertex();
[[nodiscard]] std::string shadowVertex();
[[nodiscard]] std::string tubeVertex();
[[nodiscard]] std::string ballVertex();
[[nodiscard]] std::string screenVertex();

/// What is seen at a pixel, unlit: colour and roughness, normal and item.
[[nodiscard]] std::string meshFragment();
[[nodiscard]] std::string tubeFragment(bool onTop);
[[nodiscard]] std::string ballFragment(bool onTop);
[[nodiscard]] std::string shadowFragment();

/// Light on what is seen; ground shadow; outlines.
[[nodiscard]] std::string shadeFragment();
/// The same for a view in motion, in three steps: openness, light, smooth edges.
[[nodiscard]] std::string openFragment();
[[nodiscard]] std::string motionFragment();
[[nodiscard]] std::string smoothFragment();
/// One layer of transparent surfaces, lit.
[[nodiscard]] std::string veilFragment();
/// A texture as it is.
[[nodiscard]] std::string copyFragment();
/// From summed light to sRGB over the background.
[[nodiscard]] std::string resolveFragment();

}  // namespace ecorche::render::glsl
