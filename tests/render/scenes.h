#pragma once

#include <ecorche/render/renderer.h>
#include <ecorche/render/scene.h>

#include <cmath>
#include <memory>
#include <numbers>

namespace ecorche::test {

/// A ball of latitude rings, facing outward.
inline std::shared_ptr<mesh::SurfaceMesh> ball(const mesh::Vector3& centre, double radius,
                                               int rings = 48) {
  auto m = std::make_shared<mesh::SurfaceMesh>();
  const int around = 2 * rings;
  m->V.resize((rings - 1) * around + 2, 3);
  m->F.resize(2 * around * (rings - 1), 3);
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < around; ++j) {
      const double theta = std::numbers::pi * i / rings;
      const double phi = 2.0 * std::numbers::pi * j / around;
      m->V.row((i - 1) * around + j) =
          centre + radius * mesh::Vector3(std::sin(theta) * std::cos(phi),
                                          std::sin(theta) * std::sin(phi), std::cos(theta));
    }
  const int top = (rings - 1) * around;
  m->V.row(top) = centre + radius * mesh::Vector3::UnitZ();
  m->V.row(top + 1) = centre - radius * mesh::Vector3::UnitZ();
  int f = 0;
  for (int j = 0; j < around; ++j) {
    const int k = (j + 1) % around;
    m->F.row(f++) << top, j, k;
    m->F.row(f++) << top + 1, (rings - 2) * around + k, (rings - 2) * around + j;
    for (int i = 0; i + 2 < rings; ++i) {
      const int a = i * around + j, b = i * around + k;
      m->F.row(f++) << a, a + around, b + around;
      m->F.row(f++) << a, b + around, b;
    }
  }
  return m;
}

/// A square across X, facing towards -X … of half width h, at x.
inline std::shared_ptr<mesh::SurfaceMesh> wall(double y, double h) {
  auto m = std::make_shared<mesh::SurfaceMesh>();
  m->V.resize(4, 3);
  m->V << -h, y, -h, h, y, -h, h, y, h, -h, y, h;
  m->F.resize(2, 3);
  m->F << 0, 1, 2, 0, 2, 3;
  return m;
}

inline render::SurfaceItem item(std::shared_ptr<const mesh::SurfaceMesh> mesh,
                                render::Rgba colour) {
  render::SurfaceItem i;
  i.mesh = std::move(mesh);
  i.colour = colour;
  return i;
}

/// Parallel rays along +Y, Z up, X to the right; `height` metres from top to bottom.
inline render::Camera straightCamera(double height) {
  render::Camera camera;
  camera.eye = {0.0, -10.0, 0.0};
  camera.fovDeg = 0.0;
  camera.orthoHeight = height;
  return camera;
}

/// Small and quick, nothing but light on surfaces.
inline render::PictureOptions plainOptions(int width = 160, int height = 160) {
  render::PictureOptions options;
  options.width = width;
  options.height = height;
  options.samples = 4;
  options.shadowMapSize = 256;
  options.outline = 0.0f;
  return options;
}

/// 0 to 255.
inline int luminance(const render::Pixel& p) { return (2 * p[0] + 5 * p[1] + p[2]) / 8; }

}  // namespace ecorche::test
