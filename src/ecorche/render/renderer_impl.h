#pragma once

// Private to render's sources: what a Renderer is made of. Its passes stand in renderer_lit.cpp (at
// rest), renderer_motion.cpp, renderer_volume.cpp (tissues from their fields) and renderer_over.cpp
// (what lies over the picture).

#include <ecorche/render/gpu_scene.h>
#include <ecorche/render/gpu_volume.h>
#include <ecorche/render/light_rig.h>
#include <ecorche/render/render_targets.h>
#include <ecorche/render/renderer.h>
#include <ecorche/render/shadow_fit.h>
#include <ecorche/render/views.h>

#include <array>
#include <optional>
#include <vector>

namespace ecorche::render {

/// Where a pass looks inside the pixel: spread like a tent one pixel to either side, a soft but not
/// blurred filter.
[[nodiscard]] Eigen::Vector2d jitterOf(int pass, int count);

[[nodiscard]] std::vector<float> floats(const mesh::Vector3& v);

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
  void drawInstances(const gl::Program& p, const InstanceBatch& batch) const;
  void lay(const gl::Texture& source, const gl::Framebuffer& onto, GLenum ofSource,
           GLenum ofOther) const;
};

}  // namespace ecorche::render
