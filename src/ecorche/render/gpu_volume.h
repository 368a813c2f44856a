#pragma once

// Private to render's sources.

#include <ecorche/core/result.h>
#include <ecorche/render/gl_objects.h>
#include <ecorche/render/scene.h>
#include <ecorche/render/volume_content.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace ecorche::render {

/// The records of one layer on the graphics card, and the triangles that the eye goes in by.
struct GpuVolumeLayer {
  VolumeLayer layer;
  gl::Buffer texels;
  gl::Texture texture;
  std::size_t capacity = 0;  // texels
  gl::VertexArray array;
  gl::Buffer corners;
  std::size_t cornerCapacity = 0;
  GLsizei cornerCount = 0;
};

/// A volume on the graphics card. Only records that changed go there again.
class GpuVolume {
 public:
  /// @errors NoGraphics if the records are more than a buffer texture holds
  [[nodiscard]] Result<void> update(const VolumeItem& item, const std::optional<ClipPlane>& clip);

  /// Chooses what the eye may see. Call before drawing, after update() or when the eye moved.
  ///
  /// @param box      of the scene
  /// @param middles  the picture asks for the middle of every pixel and nothing else
  void lookFrom(const Camera& camera, int width, int height, const mesh::Box& box, bool middles);

  [[nodiscard]] const mesh::Vector3& origin() const { return origin_; }
  [[nodiscard]] const std::vector<std::unique_ptr<GpuVolumeLayer>>& layers() const {
    return layers_;
  }
  [[nodiscard]] const gl::Texture& positions() const { return positions_; }  ///< of vertices
  /// Colour and roughness; opacity: two texels per column.
  [[nodiscard]] const gl::Texture& tissues() const { return tissues_; }
  /// Directions of fibres at vertices, and the corners of all tets to look them up by; only where
  /// the item has them.
  [[nodiscard]] bool hasFlow() const { return flow_ != nullptr; }
  [[nodiscard]] const gl::Texture& flow() const { return flowTexture_; }
  [[nodiscard]] const gl::Texture& tets() const { return tets_; }
  [[nodiscard]] float slack() const { return slack_; }

  [[nodiscard]] std::uint64_t contentBytes() const { return contentBytes_; }
  [[nodiscard]] std::uint64_t viewBytes() const { return viewBytes_; }
  [[nodiscard]] std::int64_t tetCount() const;
  [[nodiscard]] std::int64_t triangleCount() const;

  /// Surfaces of opaque layers, relative to origin(), made when first asked for after a change.
  [[nodiscard]] const std::vector<Eigen::Vector3f>& surface();

 private:
  std::shared_ptr<VolumeContent> content_ = std::make_shared<VolumeContent>();
  std::shared_ptr<const VolumeGeometry> geometry_;  // that positions_ is of
  mesh::Vector3 origin_ = mesh::Vector3::Zero();
  float slack_ = 0.0f;
  gl::Buffer positionData_, tissueData_, flowData_, tetData_;
  gl::Texture positions_, tissues_, flowTexture_, tets_;
  std::shared_ptr<const mesh::Directions> flow_;
  std::vector<float> tissueTable_;
  std::vector<std::unique_ptr<GpuVolumeLayer>> layers_;
  std::vector<Eigen::Vector3f> surface_;
  bool surfaceFresh_ = false;
  std::uint64_t contentBytes_ = 0;
  std::uint64_t viewBytes_ = 0;

  void uploadPositions();
  void uploadTissues(const VolumeItem& item);
  void uploadFlow(const VolumeItem& item, bool otherTets);
  [[nodiscard]] Result<void> uploadRecords(VolumeRecords& records, GpuVolumeLayer& layer);
};

}  // namespace ecorche::render
