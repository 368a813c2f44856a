#pragma once

#include <ecorche/mesh/surface_mesh.h>
#include <ecorche/mesh/tet_mesh.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

namespace ecorche::render {

/// A straight line that is looked along. `direction` is unit; what lies before `from` is not seen.
struct Ray {
  mesh::Vector3 from = mesh::Vector3::Zero();  // [m]
  mesh::Vector3 direction = mesh::Vector3::UnitY();
};

/// What drawing and ray casting need to know about the tets, made once per domain: may be made on
/// any thread and is then shared. Another domain is another object.
class VolumeGeometry {
 public:
  /// @param neighbours  #T×4, as mesh::tetAdjacency gives
  VolumeGeometry(std::shared_ptr<const mesh::TetMesh> mesh, const mesh::TetNeighbours& neighbours);

  [[nodiscard]] const mesh::TetMesh& mesh() const { return *mesh_; }
  [[nodiscard]] const mesh::TetNeighbours& neighbours() const { return neighbours_; }
  [[nodiscard]] const mesh::VertexTets& vertexTets() const { return around_; }
  [[nodiscard]] const mesh::Box& box() const { return box_; }

  /// Weights of a vertex and its neighbours, entries first[v] … first[v+1]-1. `gradient`: their sum
  /// with a field's values is the field's gradient at v, the mean over the tets around, by volume.
  /// `mean`: their sum is the mean of the field around v; a linear field keeps its value.
  struct Stencils {
    std::vector<std::int64_t> first;        ///< #V+1
    std::vector<std::int32_t> vertex;       ///< the vertex itself among them
    std::vector<Eigen::Vector3f> gradient;  ///< [1/m]
    std::vector<float> mean;                ///< [unitless]
  };
  [[nodiscard]] const Stencils& stencils() const { return stencils_; }

  /// Faces with one tet, facing outward, by tet and corner.
  [[nodiscard]] const mesh::TetBoundary& boundary() const { return boundary_; }
  /// Row of boundary() of the first boundary face of a tet, -1: it has none. The tet's others
  /// follow.
  [[nodiscard]] std::int32_t firstBoundaryFace(std::int32_t tet) const {
    return firstFace_[static_cast<std::size_t>(tet)];
  }
  /// Smoothed normals at the corners of a boundary face, edges that turn by more than 50° kept.
  [[nodiscard]] const std::array<Eigen::Vector3f, 3>& boundaryNormals(std::int32_t face) const {
    return faceNormals_[static_cast<std::size_t>(face)];
  }

  /// Groups of tets that lie near one another, for drawing front to back.
  [[nodiscard]] std::int32_t clusterCount() const { return clusterCount_; }
  [[nodiscard]] std::int32_t clusterOf(std::int32_t tet) const {
    return cluster_[static_cast<std::size_t>(tet)];
  }
  [[nodiscard]] const std::vector<std::int32_t>& tetsByCluster() const { return byCluster_; }
  [[nodiscard]] const mesh::Box& clusterBox(std::int32_t cluster) const {
    return clusterBoxes_[static_cast<std::size_t>(cluster)];
  }

  /// Where the whole line of the ray enters tets through the boundary, ordered along it; places
  /// before `from` have a distance below 0.
  struct Entry {
    std::int32_t tet = -1;
    int corner = 0;  ///< whose opposite face is entered
    double distance = 0.0;
  };
  [[nodiscard]] std::vector<Entry> entries(const Ray& ray) const;

 private:
  // A box tree over boundary faces; leaves hold a run of face numbers
  struct Node {
    Eigen::Array3f lo, hi;
    std::int32_t first = 0;  // of faces in order_, or the left child (the right one follows it)
    std::int32_t count = 0;  // 0: inner node
  };

  std::shared_ptr<const mesh::TetMesh> mesh_;
  mesh::TetNeighbours neighbours_;
  mesh::VertexTets around_;
  mesh::Box box_;
  mesh::TetBoundary boundary_;
  std::vector<std::int32_t> firstFace_;
  std::vector<std::array<Eigen::Vector3f, 3>> faceNormals_;
  Stencils stencils_;
  std::vector<std::int32_t> cluster_;
  std::vector<std::int32_t> byCluster_;  // all tets
  std::int32_t clusterCount_ = 0;
  std::vector<mesh::Box> clusterBoxes_;
  std::vector<Node> nodes_;
  std::vector<std::int32_t> order_;

  void makeStencils();
  void makeBoundary();
  void makeClusters();
  void makeTree();
};

/// On which side of the line a → b the ray passes, seen along the ray: 1 left, -1 right. Opposite
/// for b → a to the last bit, and never 0, so that a ray between two faces that share an edge meets
/// exactly one of them.
[[nodiscard]] int sideOfEdge(const Ray& ray, const mesh::Positions& V, std::int32_t a,
                             std::int32_t b);

}  // namespace ecorche::render
