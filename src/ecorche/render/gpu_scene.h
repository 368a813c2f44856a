#pragma once

// Private to render's sources.

#include <ecorche/render/gl_objects.h>
#include <ecorche/render/scene.h>
#include <ecorche/render/triangle_batch.h>

#include <map>
#include <vector>

namespace ecorche::render {

/// Instances of segments or balls; those on top are drawn last, over everything.
struct InstanceBatch {
  gl::VertexArray array;
  gl::Buffer instances;
  GLsizei count = 0;
};

/// A scene on the graphics card, but for its volume. Positions are relative to `origin`, so that 32
/// bits do for a model that lies far from zero. Only what changed is prepared again, meshes by
/// their address and revision, and only kinds of things that changed are sent again.
class GpuScene {
 public:
  /// @param inMotion  coarser surfaces will be asked for
  /// @errors NoGraphics if the scene has more items than a batch can number (32,767)
  [[nodiscard]] Result<void> upload(const Scene& scene, bool inMotion);

  [[nodiscard]] const mesh::Vector3& origin() const { return origin_; }
  [[nodiscard]] const mesh::Box& box() const {
    return box_;
  }  ///< of surfaces, lines, points and the volume, world
  [[nodiscard]] const TriangleBatch& opaque() const { return opaque_; }
  [[nodiscard]] const TriangleBatch& veils() const { return veils_; }
  [[nodiscard]] std::size_t veilItems() const { return veilItems_; }  ///< transparent surfaces
  [[nodiscard]] const InstanceBatch& tubes(bool onTop) const { return tubes_[onTop ? 1 : 0]; }
  [[nodiscard]] const InstanceBatch& balls(bool onTop) const { return balls_[onTop ? 1 : 0]; }
  /// Colour; roughness, edge opacity (-1: none), outward only: two texels per item.
  [[nodiscard]] const gl::Texture& materials() const { return materials_; }

  /// Chooses how fine surfaces are drawn in motion. Call after upload() or when the eye moved.
  void lookFrom(const Camera& camera, int height, const Eigen::Matrix4f& toClip);

 private:
  struct Prepared {
    std::shared_ptr<const mesh::SurfaceMesh>
        mesh;  // keeps the address from being given to another mesh
    std::shared_ptr<const mesh::Directions> normals;
    std::uint64_t revision = 0;
    double creaseDeg = 0.0;
    int smoothing = 0;
    ShadingMesh shading;
    std::optional<std::vector<FarFaces>> far;  // made when first wanted
    bool closed = false;
    bool used = false;
  };

  mesh::Vector3 origin_ = mesh::Vector3::Zero();
  mesh::Box box_;
  TriangleBatch opaque_;
  TriangleBatch veils_;
  std::size_t veilItems_ = 0;
  InstanceBatch tubes_[2];
  InstanceBatch balls_[2];
  gl::Buffer materialData_;
  gl::Texture materials_;
  std::map<const mesh::SurfaceMesh*, Prepared> prepared_;
  // What the buffers hold
  struct Held {
    std::vector<SurfaceItem> surfaces;
    std::vector<LineItem> lines;
    std::vector<PointItem> points;
    std::optional<ClipPlane> clip;
    mesh::Box surfaceBox, lineBox, pointBox;
    bool any = false;
    bool far = false;  // coarser surfaces too
  };
  Held held_;
  Scene capped_;  // surfaces with their cuts filled

  Prepared& prepare(const SurfaceItem& item);
  void uploadSurfaces(const Scene& scene);
  void uploadMaterials(const Scene& scene);
  void uploadLines(const Scene& scene);
  void uploadPoints(const Scene& scene);
};

}  // namespace ecorche::render
