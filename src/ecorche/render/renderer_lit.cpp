// Passes of a picture at rest: lamps with shadows, one after another into a sum.
#include <ecorche/render/renderer_impl.h>
#include <ecorche/render/shaders.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ecorche::render {

using mesh::Vector3;

// Lamps and shadow maps for a picture at rest.
void Renderer::Impl::fitLights() {
  // Shadows cost a drawing of everything per direction: in large scenes several passes share them
  const std::vector<Eigen::Vector3f> corners = casterCorners();
  const auto triangles =
      static_cast<GLsizei>(scene.opaque().casterIndices() / 3 + volumeCasterCount / 3);
  const int lightCount =
      std::clamp(options.lightsPerPass.value_or(triangles > 750'000 ? 8 : 10), 4, glsl::kMaxLights);
  passesPerLights = triangles > 1'500'000 ? 4 : triangles > 250'000 ? 2 : 1;
  rig = {.passes = (options.samples + passesPerLights - 1) / passesPerLights,
         .keyPerPass = lightCount >= 8 ? 2 : 1,
         .rimPerPass = 1,
         .skyPerPass = lightCount - (lightCount >= 8 ? 3 : 2),
         .exposure = options.exposure};
  if (shadowSize != options.shadowMapSize || shadowLayers != lightCount) {
    shadows = gl::makeShadowMaps(options.shadowMapSize, lightCount);
    shadowSize = options.shadowMapSize;
    shadowLayers = lightCount;
  }

  const Eigen::Matrix4d unjittered =
      viewProjection(camera, options.width, options.height, scene.box(), scene.origin());
  focus = shadowFocus(corners, unjittered.cast<float>());
  if (options.ground) {
    lowest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3f& p : corners)
      lowest = std::min(lowest, options.ground->normalized().dot(p.cast<double>()));
  }
}

// Opaque triangles relative to the scene's origin, those of the volume's surfaces with them.
std::vector<Eigen::Vector3f> Renderer::Impl::casterCorners() {
  std::vector<Eigen::Vector3f> corners = scene.opaque().corners();
  volumeCasterCount = 0;
  if (!showsVolume) return corners;
  const std::vector<Eigen::Vector3f>& surface = volume->surface();
  const Eigen::Vector3f shift = (volume->origin() - scene.origin()).cast<float>();
  const std::size_t first = corners.size();
  corners.reserve(first + surface.size());
  for (const Eigen::Vector3f& p : surface) corners.emplace_back(p + shift);
  volumeCasterCount = static_cast<GLsizei>(surface.size());
  glBindVertexArray(volumeCasters.id());
  glBindBuffer(GL_ARRAY_BUFFER, volumeCasterData.id());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(surface.size() * sizeof(Eigen::Vector3f)),
               surface.empty() ? nullptr : &corners[first], GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof(Eigen::Vector3f), nullptr);
  glBindVertexArray(0);
  return corners;
}

void Renderer::Impl::drawShadows() {
  glBindFramebuffer(GL_FRAMEBUFFER, shadowFrame.id());
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  glViewport(0, 0, shadowSize, shadowSize);
  glEnable(GL_DEPTH_TEST);
  glEnable(GL_DEPTH_CLAMP);  // what stands between lamp and picture but outside the fitted box
                             // shades all the same
  programs.shadow.use();
  setClip(programs.shadow);
  for (std::size_t i = 0; i < maps.size(); ++i) {
    glFramebufferTextureLayer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, shadows.id(), 0,
                              static_cast<GLint>(i));
    glClear(GL_DEPTH_BUFFER_BIT);
    programs.shadow.setMatrix("uViewProjection", maps[i].worldToClip.data());
    scene.opaque().drawCasters(!clip);
    if (volumeCasterCount > 0) {
      glBindVertexArray(volumeCasters.id());
      glVertexAttribI1ui(2, 0);
      glDrawArrays(GL_TRIANGLES, 0, volumeCasterCount);
    }
  }
  glDisable(GL_DEPTH_CLAMP);
}

void Renderer::Impl::shade() {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.lit.id());
  glDisable(GL_DEPTH_TEST);
  const gl::Program& p = programs.shade;
  p.use();
  setEye(p);
  setLights(p);
  std::vector<float> matrices;
  for (const ShadowMap& map : maps)
    matrices.insert(matrices.end(), map.worldToTexture.data(), map.worldToTexture.data() + 16);
  p.setMatrix("uShadowMatrix", matrices.data(), static_cast<int>(maps.size()));
  const float texel = static_cast<float>(focus.diameter()) / static_cast<float>(shadowSize);
  p.set("uTexel", {texel, texel / static_cast<float>(focus.depth())}, 2);
  p.set("uBounce", 0.32f);
  p.set("uOutline", options.outline);
  p.set("uSkyAbove", {0.85f, 0.87f, 0.90f}, 3);
  p.set("uSkyBelow", {0.20f, 0.18f, 0.17f}, 3);
  const bool ground = options.ground && std::isfinite(lowest);
  std::vector<float> plane = floats(ground ? options.ground->normalized() : Vector3::UnitZ());
  plane.push_back(static_cast<float>(ground ? -lowest : 0.0));
  p.set("uGround", plane, 4);
  p.set("uGroundShade", ground ? 0.75f : 0.0f);
  p.setTexture("uColourMap", 0, GL_TEXTURE_2D, targets.colour);
  p.setTexture("uNormalMap", 1, GL_TEXTURE_2D, targets.normal);
  p.setTexture("uDepthMap", 2, GL_TEXTURE_2D, targets.depth);
  p.setTexture("uShadows", 3, GL_TEXTURE_2D_ARRAY, shadows);
  drawScreen();
}

void Renderer::Impl::addUp() { lay(targets.light, targets.total, GL_ONE, GL_ONE); }

}  // namespace ecorche::render
