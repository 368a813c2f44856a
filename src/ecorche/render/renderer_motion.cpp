// The one pass of a picture in motion.
#include <ecorche/render/renderer_impl.h>

#include <Eigen/Geometry>
#include <limits>

namespace ecorche::render {

using mesh::Vector3;

namespace {

constexpr double kReachRel = 0.02;  // how far things darken each other

}  // namespace

// Only where the bound framebuffer's depth is less than empty.
void Renderer::Impl::drawScreenWhereSeen(const gl::Program& p) const {
  p.set("uDepth", 0.999999f);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_GREATER);
  glDepthMask(GL_FALSE);
  drawScreen();
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
}

// Pixels that the scene's box covers, from the lower left: x and y of its first and last.
std::array<int, 4> Renderer::Impl::boxOnScreen() const {
  const std::array<int, 4> all{0, 0, options.width - 1, options.height - 1};
  const Eigen::Matrix4d m =
      viewProjection(camera, options.width, options.height, scene.box(), scene.origin());
  Eigen::Array2d lo = Eigen::Array2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array2d hi = -lo;
  const mesh::Box& box = scene.box();
  if (box.empty()) return all;
  for (int k = 0; k < 8; ++k) {
    const Vector3 p((k & 1) ? box.hi.x() : box.lo.x(), (k & 2) ? box.hi.y() : box.lo.y(),
                    (k & 4) ? box.hi.z() : box.lo.z());
    const Eigen::Vector4d c = m * (p - scene.origin()).homogeneous();
    if (!(c.w() > 1e-9)) return all;
    lo = lo.min(c.head<2>().array() / c.w());
    hi = hi.max(c.head<2>().array() / c.w());
  }
  // Balls and tubes reach over by their radius
  constexpr double kMargin = 24.0;
  const Eigen::Array2d size(options.width, options.height);
  lo = ((0.5 * lo + 0.5) * size - kMargin).max(0.0).min(size - 1.0);
  hi = ((0.5 * hi + 0.5) * size + kMargin).max(0.0).min(size - 1.0);
  return {static_cast<int>(lo.x()), static_cast<int>(lo.y()), static_cast<int>(hi.x()),
          static_cast<int>(hi.y())};
}

// Lamps without shadows; clefts by the depth of the picture.
void Renderer::Impl::shadeInMotion() {
  glDisable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.openness.id());
  glViewport(0, 0, (options.width + 1) / 2, (options.height + 1) / 2);
  const gl::Program& o = programs.open;
  o.use();
  setEye(o);
  o.set("uReach", static_cast<float>(kReachRel * scene.box().diagonal()));
  glUniform2i(o.location("uSize2"), options.width, options.height);
  o.setTexture("uNormalMap", 0, GL_TEXTURE_2D, targets.normal);
  o.setTexture("uDepthMap", 1, GL_TEXTURE_2D, targets.depth);
  drawScreen(2);

  // Depth is read and asked at once, so that the one asked is a copy
  glBindFramebuffer(GL_READ_FRAMEBUFFER, targets.seen.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, targets.steps.id());
  glBlitFramebuffer(0, 0, options.width, options.height, 0, 0, options.width, options.height,
                    GL_DEPTH_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, targets.litWhereSeen.id());
  glViewport(0, 0, options.width, options.height);
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glClear(GL_COLOR_BUFFER_BIT);
  const gl::Program& p = programs.motion;
  p.use();
  setEye(p);
  setLights(p);
  const SkyLight sky = skyLight(options.exposure);
  p.set("uSkyAbove", {sky.above.x(), sky.above.y(), sky.above.z()}, 3);
  p.set("uSkyBelow", {sky.below.x(), sky.below.y(), sky.below.z()}, 3);
  p.set("uOutline", options.outline);
  p.setTexture("uColourMap", 0, GL_TEXTURE_2D, targets.colour);
  p.setTexture("uNormalMap", 1, GL_TEXTURE_2D, targets.normal);
  p.setTexture("uDepthMap", 2, GL_TEXTURE_2D, targets.depth);
  p.setTexture("uOpenMap", 3, GL_TEXTURE_2D, targets.open);
  drawScreenWhereSeen(p);
}

// Into the layer that veils no longer need; the picture is made from there.
void Renderer::Impl::smoothEdges() {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.smoothed.id());
  glDisable(GL_DEPTH_TEST);
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glClear(GL_COLOR_BUFFER_BIT);
  programs.smooth.use();
  programs.smooth.setTexture("uSource", 0, GL_TEXTURE_2D, targets.light);
  drawScreen();
}

}  // namespace ecorche::render
