#include <ecorche/core/contract.h>
#include <ecorche/render/offscreen.h>
#include <ecorche/render/renderer_impl.h>
#include <ecorche/render/shaders.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ecorche::render {

using mesh::Vector3;

Eigen::Vector2d jitterOf(int i, int count) {
  if (count == 1) return {0.0, 0.0};
  const auto tent = [](double u) {
    return u < 0.5 ? std::sqrt(2.0 * u) - 1.0 : 1.0 - std::sqrt(2.0 - 2.0 * u);
  };
  const auto fraction = [](double x) { return x - std::floor(x); };
  return {0.85 * tent((i + 0.5) / count), 0.85 * tent(fraction(0.5 + 0.6180339887498949 * i))};
}

std::vector<float> floats(const Vector3& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

Result<void> Renderer::Impl::begin(const Scene& newScene, const Camera& newCamera,
                                   const PictureOptions& o) {
  EC_REQUIRE(o.width > 0 && o.height > 0 && o.samples > 0 && o.shadowMapSize >= 16);
  GLint largest = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  if (std::max({o.width, o.height, o.shadowMapSize}) > largest)
    return fail(ErrorCode::NoGraphics, "the graphics driver draws pictures of at most " +
                                           std::to_string(largest) +
                                           " pixels a side; ask for a smaller one");
  options = o;
  if (o.motion) options.samples = 1;
  camera = newCamera;
  eye = eyeAxes(camera);
  clip = newScene.clip;
  background = newScene.background;
  passesDone = 0;
  if (auto ok = scene.upload(newScene, o.motion); !ok) return ok;
  showsVolume = newScene.volume.has_value();
  if (showsVolume) {
    if (!volume) volume.emplace();
    if (auto ok = volume->update(*newScene.volume, clip); !ok) return ok;
    volume->lookFrom(camera, o.width, o.height, scene.box(), options.samples == 1);
  }
  if (targets.width != o.width || targets.height != o.height) {
    auto made = Targets::make(o.width, o.height);
    if (!made) return passOn(made);
    targets = std::move(*made);
  }

  if (o.motion) {
    rig = {.passes = 1, .keyPerPass = 1, .rimPerPass = 1, .skyPerPass = 0, .exposure = o.exposure};
    passesPerLights = 1;
    window = boxOnScreen();
    const Eigen::Matrix4f toClip =
        viewProjection(camera, o.width, o.height, scene.box(), scene.origin()).cast<float>();
    scene.lookFrom(camera, o.height, toClip);
  } else {
    fitLights();
  }

  glBindFramebuffer(GL_FRAMEBUFFER, targets.total.id());
  glViewport(0, 0, o.width, o.height);
  glDisable(GL_SCISSOR_TEST);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glClear(GL_COLOR_BUFFER_BIT);
  return {};
}

void Renderer::Impl::setEye(const gl::Program& p) const {
  const bool parallel = camera.fovDeg <= 0.0;
  p.setMatrix("uViewProjection", worldToClip.data());
  p.setMatrix("uInverse", clipToWorld.data());
  p.set("uEye", floats(camera.eye - scene.origin()), 3);
  p.set("uForward", floats(-eye.back), 3);
  p.set("uRightAxis", floats(eye.right), 3);
  p.set("uUpAxis", floats(eye.up), 3);
  p.set("uParallel", parallel ? 1.0f : 0.0f);
  p.set("uPixel", static_cast<float>(pixelSize(camera, options.height)));
  p.set("uSize", {static_cast<float>(options.width), static_cast<float>(options.height)}, 2);
}

void Renderer::Impl::setLights(const gl::Program& p) const {
  std::vector<float> directions;
  std::vector<float> irradiances;
  int lamps = 0;
  for (const LightSample& light : lights) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      directions.push_back(static_cast<float>(light.direction(c)));
      irradiances.push_back(light.irradiance(c));
    }
    lamps += light.key ? 1 : 0;
  }
  p.set("uLights", static_cast<int>(lights.size()));
  p.set("uLamps", lamps);
  p.set("uLightDirection", directions, 3);
  p.set("uLightIrradiance", irradiances, 3);
}

void Renderer::Impl::setClip(const gl::Program& p) const {
  if (!clip) {
    glDisable(GL_CLIP_DISTANCE0);
    p.set("uClip", {0.0f, 0.0f, 0.0f, 1.0f}, 4);
    return;
  }
  glEnable(GL_CLIP_DISTANCE0);
  const Vector3 n = clip->normal.normalized();
  std::vector<float> plane = floats(n);
  plane.push_back(static_cast<float>(n.dot(scene.origin() - clip->point)));
  p.set("uClip", plane, 4);
}

// @param divisor  of the picture's size that the target has
void Renderer::Impl::drawScreen(int divisor) const {
  // In motion only where the scene may be: without a graphics card that is half the time
  if (options.motion) {
    const int x = window[0] / divisor;
    const int y = window[1] / divisor;
    glEnable(GL_SCISSOR_TEST);
    glScissor(x, y, window[2] / divisor - x + 1, window[3] / divisor - y + 1);
  }
  glBindVertexArray(noVertices.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_SCISSOR_TEST);
}

// A picture over what is there, each weighted by what blending says.
void Renderer::Impl::lay(const gl::Texture& source, const gl::Framebuffer& onto, GLenum ofSource,
                         GLenum ofOther) const {
  glBindFramebuffer(GL_FRAMEBUFFER, onto.id());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(ofSource, ofOther);
  programs.copy.use();
  programs.copy.set("uWeight", 1.0f);
  programs.copy.setTexture("uSource", 0, GL_TEXTURE_2D, source);
  drawScreen();
  glDisable(GL_BLEND);
}

// The eye of this pass, and switches as we want them.
void Renderer::Impl::startPass() {
  const Eigen::Matrix4d m = viewProjection(camera, options.width, options.height, scene.box(),
                                           scene.origin(), jitterOf(passesDone, options.samples));
  worldToClip = m.cast<float>();
  clipToWorld = m.inverse().cast<float>();
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_STENCIL_TEST);
  glDisable(GL_SCISSOR_TEST);
  glDisable(GL_MULTISAMPLE);
  glDisable(GL_FRAMEBUFFER_SRGB);
  glDepthMask(GL_TRUE);
  glDepthFunc(GL_LESS);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void Renderer::Impl::pass() {
  startPass();
  if (options.motion) {
    lights = lightsOfPass(camera, rig, 0);
  } else if (passesDone % passesPerLights == 0) {
    lights = lightsOfPass(camera, rig, passesDone / passesPerLights);
    maps.clear();
    for (const LightSample& light : lights)
      maps.push_back(shadowMap(focus, light.direction, shadowSize));
    drawShadows();
  }
  glViewport(0, 0, options.width, options.height);
  drawSeen();
  if (options.motion) {
    shadeInMotion();
  } else {
    shade();
  }
  drawVolumeVeils();
  drawVeils();
  drawOnTop();
  if (options.motion) {
    smoothEdges();
  } else {
    addUp();
  }
  ++passesDone;
}

void Renderer::Impl::drawSeen() {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.seen.id());
  glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  drawVolume();
  glBindFramebuffer(GL_FRAMEBUFFER, targets.seen.id());
  const gl::Program& p = programs.mesh;
  p.use();
  setEye(p);
  setClip(p);
  p.setTexture("uMaterials", 0, GL_TEXTURE_BUFFER, scene.materials());
  if (options.motion) {
    scene.opaque().drawNear(!clip);
  } else {
    scene.opaque().drawAll(!clip);
  }
  glDisable(GL_CLIP_DISTANCE0);
  drawInstances(programs.tube, scene.tubes(false));
  drawInstances(programs.ball, scene.balls(false));
}

void Renderer::Impl::resolve(int x, int y) {
  glViewport(x, y, options.width, options.height);
  glDisable(GL_DEPTH_TEST);
  glDisable(GL_BLEND);
  glDisable(GL_FRAMEBUFFER_SRGB);
  const gl::Program& p = programs.resolve;
  p.use();
  p.set("uWeight", options.motion ? 1.0f : 1.0f / static_cast<float>(std::max(1, passesDone)));
  const std::vector<float> middle(background.begin(), background.end());
  std::vector<float> corner = middle;
  if (options.gradient)
    for (std::size_t c = 0; c < 3; ++c) corner[c] *= 0.62f;
  p.set("uBackground", middle, 4);
  p.set("uBackgroundEdge", corner, 4);
  glUniform2i(p.location("uOffset"), x, y);
  const bool single = options.motion && passesDone > 0;
  p.setTexture("uSum", 0, GL_TEXTURE_2D, single ? targets.veilLight : targets.sum);
  if (single && !options.gradient) {
    // Around the scene's box there is nothing but background
    glEnable(GL_SCISSOR_TEST);
    glScissor(x, y, options.width, options.height);
    glClearColor(srgbFromLinear(background[0]), srgbFromLinear(background[1]),
                 srgbFromLinear(background[2]), background[3]);
    glClear(GL_COLOR_BUFFER_BIT);
    glScissor(x + window[0], y + window[1], window[2] - window[0] + 1, window[3] - window[1] + 1);
  }
  glBindVertexArray(noVertices.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
  glDisable(GL_SCISSOR_TEST);
  glUseProgram(0);
  glBindVertexArray(0);
  glActiveTexture(GL_TEXTURE0);
}

Renderer::Renderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::create() {
  if (epoxy_gl_version() < 33 || !epoxy_is_desktop_gl())
    return fail(ErrorCode::NoGraphics,
                "pictures need OpenGL 3.3 and the driver has less; Mesa's software renderer has it "
                "(LIBGL_ALWAYS_SOFTWARE=1)");
  auto programs = Programs::build();
  if (!programs) return passOn(programs);
  auto impl = std::make_unique<Impl>();
  impl->programs = std::move(*programs);
  return Renderer(std::move(impl));
}

Result<void> Renderer::begin(const Scene& scene, const Camera& camera,
                             const PictureOptions& options) {
  return impl_->begin(scene, camera, options);
}

bool Renderer::pass() {
  if (impl_->passesDone >= impl_->options.samples) return false;
  impl_->pass();
  return true;
}

void Renderer::passUnlit() {
  impl_->startPass();
  glViewport(0, 0, impl_->options.width, impl_->options.height);
  impl_->drawSeen();
  glFinish();
}

void Renderer::resolve(int x, int y) { impl_->resolve(x, y); }

Image Renderer::read() {
  const int width = impl_->options.width;
  const int height = impl_->options.height;
  gl::Texture target = gl::Texture::make();
  glBindTexture(GL_TEXTURE_2D, target.id());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  gl::Framebuffer frame = gl::Framebuffer::make();
  glBindFramebuffer(GL_FRAMEBUFFER, frame.id());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.id(), 0);
  impl_->resolve(0, 0);

  Image bottomUp(width, height);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, bottomUp.pixels.data());
  Image image(width, height);
  for (int y = 0; y < height; ++y)
    std::copy_n(&bottomUp.at(0, height - 1 - y), width, &image.at(0, y));
  return image;
}

TissueImage Renderer::readTissues() {
  const int width = impl_->options.width;
  const int height = impl_->options.height;
  TissueImage image(width, height);
  std::vector<float> texels(4 * image.tissue.size());
  glBindFramebuffer(GL_FRAMEBUFFER, impl_->targets.seen.id());
  glReadBuffer(GL_COLOR_ATTACHMENT1);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, texels.data());
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float* texel = &texels[4 * image.index(x, height - 1 - y)];
      if (texel[3] > -0.5f) continue;
      const std::size_t i = image.index(x, y);
      image.tissue[i] = TissueId(static_cast<std::int64_t>(-texel[3]));
      image.normal[i] = Eigen::Vector3f(texel[0], texel[1], texel[2]).normalized();
    }
  return image;
}

Renderer::VolumeUploads Renderer::volumeUploads() const {
  if (!impl_->showsVolume) return {};
  return {impl_->volume->contentBytes(), impl_->volume->viewBytes(), impl_->volume->tetCount(),
          impl_->volume->triangleCount()};
}

Result<Image> renderPicture(const Scene& scene, const Camera& camera, const PictureOptions& options,
                            RunContext& run) {
  const Stage stage(run, "picture");
  auto context = OffscreenContext::create();
  if (!context) return passOn(context);
  auto renderer = Renderer::create();
  if (!renderer) return passOn(renderer);
  if (auto ok = renderer->begin(scene, camera, options); !ok) return passOn(ok);
  for (int done = 0; renderer->pass(); ++done) {
    glFinish();
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "picture");
    run.progress("picture", (done + 1.0) / options.samples);
  }
  return renderer->read();
}

}  // namespace ecorche::render
