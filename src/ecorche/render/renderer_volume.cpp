// Tissues drawn straight from their fields (docs/algorithms/volume_rendering.md).
#include <ecorche/render/renderer_impl.h>

#include <Eigen/LU>

namespace ecorche::render {

using mesh::Vector3;

namespace {

constexpr double kGrainRel = 0.0012;  // width of the streaks along fibres

}  // namespace

// Places are relative to the volume's own origin, moved with the layer.
void Renderer::Impl::setVolume(const gl::Program& p, const GpuVolumeLayer& layer) const {
  const Vector3 origin = volume->origin() + layer.layer.shift;
  const Eigen::Matrix4d m = viewProjection(camera, options.width, options.height, scene.box(),
                                           origin, jitterOf(passesDone, options.samples));
  const Eigen::Matrix4f toClip = m.cast<float>();
  const Eigen::Matrix4f fromClip = m.inverse().cast<float>();
  p.setMatrix("uViewProjection", toClip.data());
  p.setMatrix("uInverse", fromClip.data());
  p.set("uEye", floats(camera.eye - origin), 3);
  p.set("uForward", floats(-eye.back), 3);
  p.set("uUpAxis", floats(eye.up), 3);
  p.set("uParallel", camera.fovDeg <= 0.0 ? 1.0f : 0.0f);
  p.set("uSlack", volume->slack());
  std::vector<float> plane{0.0f, 0.0f, 0.0f, 1.0f};
  if (clip) {
    const Vector3 n = clip->normal.normalized();
    plane = floats(n);
    plane.push_back(static_cast<float>(n.dot(volume->origin() - clip->point)));
  }
  p.set("uClip", plane, 4);
  p.setTexture("uRecords", 0, GL_TEXTURE_BUFFER, layer.texture);
}

// Which record is seen at every pixel, and how far from the eye.
void Renderer::Impl::findSteps(const GpuVolumeLayer& layer) {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.steps.id());
  const GLuint nothing[4] = {0xffffffffu, 0u, 0u, 0u};
  glClearBufferuiv(GL_COLOR, 0, nothing);
  glClear(GL_DEPTH_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  glDisable(GL_CULL_FACE);
  const gl::Program& p = programs.volume;
  p.use();
  setVolume(p, layer);
  p.setTexture("uPositions", 1, GL_TEXTURE_BUFFER, volume->positions());
  glBindVertexArray(layer.array.id());
  glDrawArrays(GL_TRIANGLES, 0, layer.cornerCount);
}

void Renderer::Impl::drawVolume() {
  if (!showsVolume) return;
  std::vector<const GpuVolumeLayer*> opaque;
  for (const auto& layer : volume->layers())
    if (!layer->layer.veil && layer->cornerCount > 0) opaque.push_back(layer.get());
  const auto setFound = [&](const gl::Program& p, const GpuVolumeLayer& layer) {
    p.use();
    setVolume(p, layer);
    p.setTexture("uFound", 1, GL_TEXTURE_2D, targets.found);
    p.setTexture("uTissues", 2, GL_TEXTURE_BUFFER, volume->tissues());
    p.set("uPixel", static_cast<float>(pixelSize(camera, options.height)));
    p.set("uGrain",
          volume->hasFlow() ? static_cast<float>(kGrainRel * scene.box().diagonal()) : 0.0f);
    // Samplers of different kinds may not share a unit, used or not
    p.set("uTets", 3);
    p.set("uFlow", 4);
    if (volume->hasFlow()) {
      p.setTexture("uTets", 3, GL_TEXTURE_BUFFER, volume->tets());
      p.setTexture("uFlow", 4, GL_TEXTURE_BUFFER, volume->flow());
    }
  };
  if (opaque.size() == 1) {
    // Looking records up only where something was found: a depth test answers that for whole blocks
    findSteps(*opaque[0]);
    glBindFramebuffer(GL_FRAMEBUFFER, targets.stepsSeen.id());
    setFound(programs.volumeSurfaceOnly, *opaque[0]);
    drawScreenWhereSeen(programs.volumeSurfaceOnly);
    glBindFramebuffer(GL_FRAMEBUFFER, targets.seen.id());
    glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
    setFound(programs.volumeDepth, *opaque[0]);
    drawScreen();
    glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
    return;
  }
  for (const GpuVolumeLayer* layer : opaque) {
    findSteps(*layer);
    glBindFramebuffer(GL_FRAMEBUFFER, targets.seen.id());
    setFound(programs.volumeSurface, *layer);
    drawScreen();
  }
}

// X-rayed tissues over what is opaque, under the skin.
void Renderer::Impl::drawVolumeVeils() {
  if (!showsVolume) return;
  for (const auto& layer : volume->layers()) {
    if (!layer->layer.veil || layer->cornerCount == 0) continue;
    findSteps(*layer);
    glBindFramebuffer(GL_FRAMEBUFFER, targets.lit.id());
    glDisable(GL_DEPTH_TEST);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
    const gl::Program& p = programs.volumeVeil;
    p.use();
    setVolume(p, *layer);
    setLights(p);
    p.set("uSkyAbove", {0.44f, 0.44f, 0.45f}, 3);
    p.set("uSkyBelow", {0.24f, 0.22f, 0.21f}, 3);
    p.setTexture("uFound", 1, GL_TEXTURE_2D, targets.found);
    p.setTexture("uTissues", 2, GL_TEXTURE_BUFFER, volume->tissues());
    p.setTexture("uDepthMap", 3, GL_TEXTURE_2D, targets.depth);
    drawScreen();
    glDisable(GL_BLEND);
  }
}

}  // namespace ecorche::render
