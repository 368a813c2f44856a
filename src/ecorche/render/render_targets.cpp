#include <ecorche/render/render_targets.h>
#include <ecorche/render/shaders.h>
#include <ecorche/render/volume_shaders.h>

namespace ecorche::render {

Result<Programs> Programs::build() {
  Programs p;
  const auto make = [](gl::Program& into, const char* name, const std::string& vertex,
                       const std::string& fragment) -> Result<void> {
    auto program = gl::Program::build(name, vertex, fragment);
    if (!program) return passOn(program);
    into = std::move(*program);
    return {};
  };
  Result<void> ok;
  if (ok) ok = make(p.volume, "volume", glsl::volumeVertex(), glsl::volumeFragment());
  if (ok)
    ok = make(p.volumeSurface, "volume surface", glsl::screenVertex(),
              glsl::volumeSurfaceFragment(true));
  if (ok)
    ok = make(p.volumeSurfaceOnly, "volume surface without depth", glsl::screenVertex(),
              glsl::volumeSurfaceFragment(false));
  if (ok)
    ok = make(p.volumeDepth, "volume depth", glsl::screenVertex(), glsl::volumeDepthFragment());
  if (ok) ok = make(p.volumeVeil, "volume veil", glsl::screenVertex(), glsl::volumeVeilFragment());
  if (ok) ok = make(p.mesh, "mesh", glsl::meshVertex(), glsl::meshFragment());
  if (ok) ok = make(p.shadow, "shadow", glsl::shadowVertex(), glsl::shadowFragment());
  if (ok) ok = make(p.tube, "tube", glsl::tubeVertex(), glsl::tubeFragment(false));
  if (ok) ok = make(p.tubeOnTop, "tube on top", glsl::tubeVertex(), glsl::tubeFragment(true));
  if (ok) ok = make(p.ball, "ball", glsl::ballVertex(), glsl::ballFragment(false));
  if (ok) ok = make(p.ballOnTop, "ball on top", glsl::ballVertex(), glsl::ballFragment(true));
  if (ok) ok = make(p.shade, "shade", glsl::screenVertex(), glsl::shadeFragment());
  if (ok) ok = make(p.open, "openness", glsl::screenVertex(), glsl::openFragment());
  if (ok) ok = make(p.motion, "motion", glsl::screenVertex(), glsl::motionFragment());
  if (ok) ok = make(p.smooth, "smooth edges", glsl::screenVertex(), glsl::smoothFragment());
  if (ok) ok = make(p.veil, "veil", glsl::meshVertex(), glsl::veilFragment());
  if (ok) ok = make(p.copy, "copy", glsl::screenVertex(), glsl::copyFragment());
  if (ok) ok = make(p.resolve, "resolve", glsl::screenVertex(), glsl::resolveFragment());
  if (!ok) return passOn(ok);
  return p;
}

Result<Targets> Targets::make(int width, int height) {
  Targets t;
  t.width = width;
  t.height = height;
  const auto half = [&] { return gl::makeTexture2D(GL_RGBA16F, width, height); };
  const auto deep = [&] { return gl::makeTexture2D(GL_DEPTH_COMPONENT32F, width, height); };
  t.colour = half();
  t.normal = half();
  t.depth = deep();
  t.light = half();
  t.veilLight = half();
  t.veilDepth[0] = deep();
  t.veilDepth[1] = deep();
  t.veilSum = half();
  t.sum = gl::makeTexture2D(GL_RGBA32F, width, height);
  const auto frame = [](gl::Framebuffer& into, const std::vector<const gl::Texture*>& colours,
                        const gl::Texture* depth) -> Result<void> {
    auto made = gl::makeFramebuffer(colours, depth);
    if (!made) return passOn(made);
    into = std::move(*made);
    return {};
  };
  t.found = gl::makeTexture2D(GL_RG32UI, width, height);
  t.foundDepth = deep();
  Result<void> ok;
  if (ok) ok = frame(t.steps, {&t.found}, &t.foundDepth);
  t.open = gl::makeTexture2D(GL_RG32F, (width + 1) / 2, (height + 1) / 2);
  if (ok) ok = frame(t.stepsSeen, {&t.colour, &t.normal}, &t.foundDepth);
  if (ok) ok = frame(t.litWhereSeen, {&t.light}, &t.foundDepth);
  if (ok) ok = frame(t.openness, {&t.open}, nullptr);
  if (ok) ok = frame(t.smoothed, {&t.veilLight}, nullptr);
  if (ok) ok = frame(t.seen, {&t.colour, &t.normal}, &t.depth);
  if (ok) ok = frame(t.lit, {&t.light}, nullptr);
  if (ok) ok = frame(t.layer[0], {&t.veilLight}, &t.veilDepth[0]);
  if (ok) ok = frame(t.layer[1], {&t.veilLight}, &t.veilDepth[1]);
  if (ok) ok = frame(t.veils, {&t.veilSum}, nullptr);
  if (ok) ok = frame(t.total, {&t.sum}, nullptr);
  if (!ok) return passOn(ok);
  return t;
}

}  // namespace ecorche::render
