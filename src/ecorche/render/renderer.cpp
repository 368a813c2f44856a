#include <ecorche/core/contract.h>
#include <ecorche/render/gpu_scene.h>
#include <ecorche/render/gpu_volume.h>
#include <ecorche/render/light_rig.h>
#include <ecorche/render/offscreen.h>
#include <ecorche/render/renderer.h>
#include <ecorche/render/shaders.h>
#include <ecorche/render/shadow_fit.h>
#include <ecorche/render/views.h>
#include <ecorche/render/volume_shaders.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ecorche::render {
namespace {

using mesh::Vector3;

constexpr int kMaxVeils = 4;          // layers of transparent surfaces told apart in a pixel
constexpr double kGrainRel = 0.0012;  // width of the streaks along fibres
constexpr double kReachRel = 0.02;    // how far things darken each other in a view in motion

struct Programs {
  gl::Program volume, volumeSurface, volumeSurfaceOnly, volumeDepth, volumeVeil;
  gl::Program mesh, shadow, tube, tubeOnTop, ball, ballOnTop, shade, veil, copy, resolve;
  gl::Program open, motion, smooth;

  static Result<Programs> build() {
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
    if (ok)
      ok = make(p.volumeVeil, "volume veil", glsl::screenVertex(), glsl::volumeVeilFragment());
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
};

// Textures of the picture's size, and the framebuffers that draw into them.
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

  static Result<Targets> make(int width, int height) {
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
};

// The i-th place inside the pixel, spread like a tent one pixel to either side: a soft but not
// blurred filter.
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

}  // namespace

struct Renderer::Impl {
  Programs programs;
  Targets targets;
  GpuScene scene;
  std::optional<GpuVolume> volume;
  gl::VertexArray noVertices = gl::VertexArray::make();
  gl::Framebuffer shadowFrame = gl::Framebuffer::make();
  gl::Texture shadows;
  gl::Query drawn = gl::Query::make();
  gl::VertexArray volumeCasters = gl::VertexArray::make();
  gl::Buffer volumeCasterData = gl::Buffer::make();
  GLsizei volumeCasterCount = 0;
  bool showsVolume = false;
  std::array<int, 4> window{};  // what screen passes of a view in motion are kept to
  int shadowSize = 0;
  int shadowLayers = 0;

  Camera camera;
  EyeAxes eye;
  PictureOptions options;
  LightRigOptions rig;
  std::optional<ClipPlane> clip;
  Rgba background{};
  ShadowFocus focus;
  double lowest = 0.0;  // along options.ground
  int passesDone = 0;
  int passesPerLights = 1;

  // Set anew for every pass
  Eigen::Matrix4f worldToClip, clipToWorld;
  std::vector<LightSample> lights;
  std::vector<ShadowMap> maps;

  Result<void> begin(const Scene& newScene, const Camera& newCamera, const PictureOptions& o);
  void fitLights();
  void startPass();
  void pass();
  void drawShadows();
  void drawSeen();
  void findSteps(const GpuVolumeLayer& layer);
  void drawVolume();
  void drawVolumeVeils();
  void shade();
  void shadeInMotion();
  void smoothEdges();
  void drawVeils();
  void drawOnTop();
  void addUp();
  void resolve(int x, int y);

  void setEye(const gl::Program& p) const;
  void setLights(const gl::Program& p) const;
  void setClip(const gl::Program& p) const;
  void setVolume(const gl::Program& p, const GpuVolumeLayer& layer) const;
  std::vector<Eigen::Vector3f> casterCorners();
  void drawScreen(int divisor = 1) const;
  void drawScreenWhereSeen(const gl::Program& p) const;
  std::array<int, 4> boxOnScreen() const;
  void drawTubes(const gl::Program& p, bool onTop) const;
  void drawBalls(const gl::Program& p, bool onTop) const;
};

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

void Renderer::Impl::drawTubes(const gl::Program& p, bool onTop) const {
  const InstanceBatch& batch = scene.tubes(onTop);
  if (batch.count == 0) return;
  p.use();
  setEye(p);
  glBindVertexArray(batch.array.id());
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, batch.count);
}

void Renderer::Impl::drawBalls(const gl::Program& p, bool onTop) const {
  const InstanceBatch& batch = scene.balls(onTop);
  if (batch.count == 0) return;
  p.use();
  setEye(p);
  glBindVertexArray(batch.array.id());
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, batch.count);
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
  drawTubes(programs.tube, false);
  drawBalls(programs.ball, false);
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
    glBindFramebuffer(GL_FRAMEBUFFER, targets.veils.id());
    glDisable(GL_DEPTH_TEST);
    glDisable(GL_CLIP_DISTANCE0);
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE_MINUS_DST_ALPHA, GL_ONE);
    programs.copy.use();
    programs.copy.set("uWeight", 1.0f);
    programs.copy.setTexture("uSource", 0, GL_TEXTURE_2D, targets.veilLight);
    drawScreen();
    glDisable(GL_BLEND);
  }
  glDisable(GL_CLIP_DISTANCE0);

  glBindFramebuffer(GL_FRAMEBUFFER, targets.lit.id());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  programs.copy.use();
  programs.copy.set("uWeight", 1.0f);
  programs.copy.setTexture("uSource", 0, GL_TEXTURE_2D,
                           layers == 1 ? targets.veilLight : targets.veilSum);
  drawScreen();
  glDisable(GL_BLEND);
}

void Renderer::Impl::drawOnTop() {
  if (scene.tubes(true).count == 0 && scene.balls(true).count == 0) return;
  glBindFramebuffer(GL_FRAMEBUFFER, targets.lit.id());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  drawTubes(programs.tubeOnTop, true);
  drawBalls(programs.ballOnTop, true);
  glDisable(GL_BLEND);
}

void Renderer::Impl::addUp() {
  glBindFramebuffer(GL_FRAMEBUFFER, targets.total.id());
  glDisable(GL_DEPTH_TEST);
  glEnable(GL_BLEND);
  glBlendFunc(GL_ONE, GL_ONE);
  programs.copy.use();
  programs.copy.set("uWeight", 1.0f);
  programs.copy.setTexture("uSource", 0, GL_TEXTURE_2D, targets.light);
  drawScreen();
  glDisable(GL_BLEND);
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
