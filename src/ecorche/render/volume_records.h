#pragma once

// Private to render's sources.

#include <ecorche/render/scene.h>
#include <ecorche/render/volume_layers.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace ecorche::render {

/// The tets in which something of a layer can be seen, each with what a shader needs to follow a
/// ray through it. Kept in step with fields, visibility and clip plane; knows no OpenGL.
///
/// A record is a run of texels of four 32-bit words; f stands for a float's bits:
///   0–2  f gradient of barycentric coordinate 1, 2, 3 (xyz) and corner 0's x, y, z (w)
///   3    seen candidates | hidden candidates << 8 | boundary faces << 16; tet; four 16-bit
///        candidates (column | kCutBit)
///   then f values of every candidate but the first at the four corners, less the first's
///   then for every seen × hidden candidate the smooth normals at the four corners, octahedral
///   then for every boundary face those at its three corners
///   then further candidates, eight to a texel
/// Candidates are those that are on top somewhere in the tet, seen ones first.
class VolumeRecords {
 public:
  using Texel = std::array<std::uint32_t, 4>;
  static constexpr std::uint32_t kCutBit = 0x8000u;

  /// A corner of a triangle that is drawn: vertex of the mesh; record << 3 | code, where code is 0,
  /// or 1 + k where the triangle is the boundary face opposite corner k.
  using Corner = std::array<std::uint32_t, 2>;

  /// Texels [begin, end) that changed.
  using Range = std::pair<std::size_t, std::size_t>;

  /// What is drawn, relative to origin(). For parallel rays `forward` decides.
  struct Eye {
    Eigen::Vector3f at = Eigen::Vector3f::Zero();
    Eigen::Vector3f forward = Eigen::Vector3f::UnitY();
    bool parallel = false;
    Eigen::Matrix4f worldToClip = Eigen::Matrix4f::Identity();
    /// Size of a picture that asks for one place per pixel, its middle: what covers none is left
    /// out. 0: no such thing is known [pixels].
    Eigen::Array2f pixels = Eigen::Array2f::Zero();
  };

  /// @param smoothed  of the item's fields, in step with them
  void update(const VolumeItem& item, const SmoothedFields& smoothed, const VolumeLayer& layer,
              const std::optional<ClipPlane>& clip);

  [[nodiscard]] const mesh::Vector3& origin() const { return origin_; }
  [[nodiscard]] const std::vector<Texel>& texels() const { return texels_; }
  /// Since the last time it was asked, ascending; neighbours closer than a kilobyte are joined.
  [[nodiscard]] std::vector<Range> takeChanges();
  [[nodiscard]] std::int64_t drawnTets() const { return drawnCount_; }

  /// Triangles through which rays go into tets where they may meet something: front to back by
  /// groups of tets, three corners each.
  void trianglesFrom(const Eye& eye, std::vector<Corner>& corners) const;

  /// Surfaces of what is seen as triangles, for shadows: exact where a tet holds two tissues.
  /// Three corners each, relative to origin.
  void surfaceTriangles(std::vector<Eigen::Vector3f>& corners) const;

 private:
  // A tet on the card, as far as deciding what an eye sees of it needs
  struct Drawn {
    std::uint32_t record = 0;
    std::uint32_t size = 0;  // of the record, texels; 0: nothing here
    std::int32_t tet = -1;
    std::array<std::int32_t, 4> vertex{};
    Eigen::Matrix<float, 3, 4> barycentric;  // coordinates 1 to 3: gradient and value at origin
    Eigen::Vector4f interface;  // where two tissues meet: unit normal into the seen one; 0: several
    std::uint8_t innerFaces = 0;     // through which a hidden tissue may be entered
    std::uint8_t boundaryFaces = 0;  // where something seen begins
  };
  struct Made {
    Drawn drawn;
    std::size_t first = 0;  // of its texels
  };
  struct Chunk {
    std::vector<Made> made;
    std::vector<Texel> texels;
  };

  std::shared_ptr<const VolumeGeometry> geometry_;
  std::shared_ptr<const tissue::FieldMatrix> fields_;
  std::uint64_t fieldsRevision_ = 0;
  bool fatIsCandidate_ = true;
  VolumeLayer layer_;
  std::optional<ClipPlane> clip_;

  mesh::Vector3 origin_ = mesh::Vector3::Zero();
  std::vector<std::int16_t> owner_;      // #V, column
  std::vector<std::uint8_t> kept_;       // #V by the clip plane; empty: no plane
  std::vector<std::int32_t> cutTets_;    // ascending
  std::vector<std::int32_t> slotOfTet_;  // into drawn_, -1: not drawn
  std::vector<Drawn> drawn_;
  std::vector<std::int32_t> freeSlots_;
  std::vector<std::vector<std::int32_t>> slotsOfCluster_;
  std::vector<Texel> texels_;
  std::map<std::uint32_t, std::vector<std::uint32_t>> freeRecords_;  // by size
  std::vector<Range> changes_;
  std::int64_t drawnCount_ = 0;

  [[nodiscard]] bool isCut(std::int32_t tet) const;
  [[nodiscard]] std::vector<Eigen::Array2f> onScreen(const Eye& eye) const;
  [[nodiscard]] std::int16_t ownerAt(std::int64_t vertex) const;
  void updateOwners();
  [[nodiscard]] std::vector<std::int32_t> updateOwners(const std::vector<std::int32_t>& vertices);
  [[nodiscard]] bool holds(std::int32_t tet, std::int32_t column) const;
  [[nodiscard]] std::vector<std::int32_t> affected(const FieldChange& change,
                                                   const std::vector<std::int32_t>& others) const;
  [[nodiscard]] std::vector<std::int32_t> updateClip(const std::optional<ClipPlane>& clip);
  void rebuild(const std::vector<std::int32_t>& tets, const SmoothedFields& smoothed, bool all);
  void make(std::int32_t tet, const SmoothedFields& smoothed, Chunk& out) const;
  void store(const Made& made, const Chunk& from);
  void remove(std::int32_t tet);
};

}  // namespace ecorche::render
