// What lies over the picture: transparent surfaces, curves, control points.
#include <ecorche/render/renderer_impl.h>

namespace ecorche::render {
namespace {

constexpr int kMaxVeils = 4;  // layers of transparent surfaces told apart in a pixel

}  // namespace

void Renderer::Impl::drawInstances(const gl::Program& p, const InstanceBatch& batch) const {
  if (batch.count == 0) return;
  p.use();
  setEye(p);
  glBindVertexArray(batch.array.id());
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, batch.count);
}

// Depth peeling, front to back [Everitt 2001]: each layer is what lies just behind the last one.
void Renderer::Impl::drawVeils() {
  if (scene.veils().empty()) return;
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  const int layers = options.motion ? scene.veilItems() > 1 ? 2 : 1 : kMaxVeils;
  if (layers > 1) {
    glBindFramebuffer(GL_FRAMEBUFFER, targets.veils.id());
    glClear(GL_COLOR_BUFFER_BIT);
  }
  // Before the first layer nothing is peeled: the "last" depth is 0
  glBindFramebuffer(GL_FRAMEBUFFER, targets.layer[1].id());
  glClearDepth(0.0);
  glClear(GL_DEPTH_BUFFER_BIT);
  glClearDepth(1.0);

  for (int layer = 0; layer < layers; ++layer) {
    const int now = layer % 2;
    glBindFramebuffer(GL_FRAMEBUFFER, targets.layer[now].id());
    glEnable(GL_DEPTH_TEST);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    const gl::Program& p = programs.veil;
    p.use();
    setEye(p);
    setLights(p);
    setClip(p);
    p.set("uSkyAbove", {0.44f, 0.44f, 0.45f}, 3);
    p.set("uSkyBelow", {0.24f, 0.22f, 0.21f}, 3);
    p.setTexture("uMaterials", 0, GL_TEXTURE_BUFFER, scene.materials());
    p.setTexture("uDepthMap", 1, GL_TEXTURE_2D, targets.depth);
    p.setTexture("uLastLayer", 2, GL_TEXTURE_2D, targets.veilDepth[1 - now]);
    // Single pixels at folds are not worth a layer; asking for their number waits for the card
    if (!options.motion) glBeginQuery(GL_SAMPLES_PASSED, drawn.id());
    if (options.motion) {
      scene.veils().drawNear(false);
    } else {
      scene.veils().drawAll(false);
    }
    if (!options.motion) {
      glEndQuery(GL_SAMPLES_PASSED);
      GLuint count = 0;
      glGetQueryObjectuiv(drawn.id(), GL_QUERY_RESULT, &count);
      if (count < static_cast<GLuint>(layer * (options.width * options.height / 5000)) + 1) break;
    }

    if (layers == 1) break;

    // Under what was peeled before
    glDisable(GL_CLIP_DISTANCE0);
    lay(targets.veilLight, targets.veils, GL_ONE_MINUS_DST_ALPHA, GL_ONE);
  }
  glDisable(GL_CLIP_DISTANCE0);
  lay(layers == 1 ? targets.veilLight : targets.veilSum, targets.lit, GL_ONE,
      GL_ONE_MINUS_SRC_ALPHA);
}

void Renderer::Impl::drawOnTop() {
  if (scene.tubes(true).count == 0 && scene.balls(true).count == 0) return;
  glBindFramebuffer(GL_FRAMEBUFFER, targets.lit.id());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  drawInstances(programs.tubeOnTop, scene.tubes(true));
  drawInstances(programs.ballOnTop, scene.balls(true));
  glDisable(GL_BLEND);
}

}  // namespace ecorche::render
