#pragma once

// Private to render's sources: GLSL 3.30 texts, complete with their #version line. Layout of
// records: volume_records.h.

#include <string>

namespace ecorche::render::glsl {

/// A corner of a tet's face. Positions are relative to the volume's own origin.
[[nodiscard]] std::string volumeVertex();
/// The first step from a hidden to a seen tissue along the ray inside the tet: record and kind, and
/// distance from the eye. Fragments without one are discarded; depth is that of the face, which
/// orders tets as well as the step itself would, since they do not overlap.
[[nodiscard]] std::string volumeFragment();
/// What was found, as colour and normal of a picture, with its depth or without.
[[nodiscard]] std::string volumeSurfaceFragment(bool withDepth);
/// Its depth alone.
[[nodiscard]] std::string volumeDepthFragment();
/// The same as a lit veil.
[[nodiscard]] std::string volumeVeilFragment();

}  // namespace ecorche::render::glsl
