#pragma once

// Private to render's sources.

#include <ecorche/render/far_faces.h>
#include <ecorche/render/gl_objects.h>
#include <ecorche/render/scene.h>
#include <ecorche/render/shading_mesh.h>

#include <array>
#include <cstdint>
#include <vector>

namespace ecorche::render {

struct SurfaceVertex {
  float position[3];
  std::int16_t normal[3];
  std::uint16_t item;  // highest bit: not clipped
  std::uint16_t colour[4];
};
static_assert(sizeof(SurfaceVertex) == 28);
inline constexpr std::uint16_t kNotClipped = 0x8000u;

/// Triangles of many surfaces in one buffer. A pass at rest draws all of them at once; one in
/// motion draws of every surface what its distance asks for.
class TriangleBatch {
 public:
  /// What kind of triangles, in the order in which they lie.
  enum class Kind : std::uint8_t {
    Closed,  ///< casts shadows, and its backs never show, unless something is cut open
    Open,    ///< casts shadows
    Unshaded
  };

  void clear();
  /// Adds a surface; kinds ascend.
  /// @param far  coarser faces; not with colours of faces
  void add(const SurfaceItem& item, const ShadingMesh& shading, const std::vector<FarFaces>* far,
           std::uint16_t number, Kind kind, const mesh::Vector3& origin);
  /// To the card.
  void upload();

  [[nodiscard]] bool empty() const { return end_.back() == 0; }
  /// Of triangles that cast shadows.
  [[nodiscard]] GLsizei casterIndices() const { return end_[1]; }
  [[nodiscard]] const std::vector<Eigen::Vector3f>& corners() const { return corners_; }

  /// Chooses for drawNear() what is in the picture, as fine as pixels are.
  ///
  /// @param toClip  of places relative to `origin`
  void lookFrom(const Camera& camera, int height, const Eigen::Matrix4f& toClip,
                const mesh::Vector3& origin);

  /// @param cullBacks  of closed surfaces: half of all triangles
  void drawAll(bool cullBacks) const;
  void drawCasters(bool cullBacks) const;
  void drawNear(bool cullBacks) const;  ///< what lookFrom() chose
  [[nodiscard]] std::int64_t nearTriangles() const;

 private:
  struct Level {
    std::size_t first = 0;  // of indices
    GLsizei count = 0;
    double cell = 0.0;  // [m]
  };
  struct Surface {
    mesh::Box box;  // in the world
    Kind kind = Kind::Closed;
    std::vector<Level> levels;  // finest first
  };
  struct Chosen {
    std::vector<GLsizei> counts;
    std::vector<const void*> offsets;
    void draw() const;
  };

  gl::VertexArray array_;
  gl::Buffer vertexData_, indexData_;
  std::vector<SurfaceVertex> vertices_;  // until they are on the card
  std::vector<std::uint32_t> indices_;
  std::vector<std::uint32_t> farIndices_;  // behind the others
  std::vector<Surface> surfaces_;
  std::array<GLsizei, 3> end_{};  // of indices, by kind
  std::vector<Eigen::Vector3f> corners_;
  Chosen closed_, open_;

  void draw(GLsizei count, bool cullBacks) const;
};

}  // namespace ecorche::render
