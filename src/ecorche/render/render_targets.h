#pragma once

// Private to render's sources: the programs and textures of a Renderer.

#include <ecorche/core/result.h>
#include <ecorche/render/gl_objects.h>

namespace ecorche::render {

/// Every program that passes use.
struct Programs {
  gl::Program volume, volumeSurface, volumeSurfaceOnly, volumeDepth, volumeVeil;
  gl::Program mesh, shadow, tube, tubeOnTop, ball, ballOnTop, shade, veil, copy, resolve;
  gl::Program open, motion, smooth;

  /// @errors NoGraphics: the driver refuses one
  [[nodiscard]] static Result<Programs> build();
};

/// Textures of the picture's size, and the framebuffers that draw into them.
struct Targets {
  int width = 0;
  int height = 0;
  gl::Texture colour, normal, depth;  // what is seen
  gl::Texture light;                  // lit, with veils
  gl::Texture veilLight, veilDepth[2], veilSum;
  gl::Texture sum;                // over passes
  gl::Texture found, foundDepth;  // records of the volume, and the faces they were entered by
  gl::Texture open;               // openness at half the size, for views in motion
  gl::Framebuffer steps, openness, smoothed;
  gl::Framebuffer stepsSeen, litWhereSeen;  // with foundDepth as the depth that is asked
  gl::Framebuffer seen, lit, layer[2], veils, total;

  /// @errors NoGraphics
  [[nodiscard]] static Result<Targets> make(int width, int height);
};

}  // namespace ecorche::render
