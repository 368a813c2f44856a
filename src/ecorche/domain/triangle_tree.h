#pragma once

#include <ecorche/mesh/types.h>

#include <limits>
#include <optional>
#include <vector>

namespace ecorche::domain {

/// Boxes over triangles (a, b, b is a segment) for the questions that resampling asks by the
/// million: is the surface within r of this point, where is it closest, how far along a ray.
class TriangleTree {
 public:
  TriangleTree() = default;
  TriangleTree(const mesh::Positions& V, const mesh::Triangles& F);

  struct Closest {
    mesh::Vector3 point = mesh::Vector3::Zero();
    double distance2 = std::numeric_limits<double>::infinity();
    std::int32_t triangle = -1;  ///< row of F; -1: nothing nearer than asked
  };
  /// The point nearest to p that is nearer than sqrt(limit2).
  [[nodiscard]] Closest closest(const mesh::Vector3& p,
                                double limit2 = std::numeric_limits<double>::infinity()) const;
  /// True where some triangle is within r of p: stops at the first.
  [[nodiscard]] bool within(const mesh::Vector3& p, double r) const;
  /// Smallest parameter t in (tMin, tMax) at which origin + t·direction meets a triangle.
  [[nodiscard]] std::optional<double> firstHit(const mesh::Vector3& origin,
                                               const mesh::Vector3& direction, double tMin,
                                               double tMax) const;
  [[nodiscard]] mesh::Vector3 normal(std::int32_t triangle) const;  ///< not normalised
  [[nodiscard]] bool empty() const { return nodes_.empty(); }

 private:
  struct Triangle {
    mesh::Vector3 a, b, c;
    std::int32_t row;
  };
  struct Node {
    Eigen::Array3d lo, hi;
    std::int32_t first = 0;  // of triangles in a leaf, of two children otherwise
    std::int32_t count = 0;  // of triangles; 0: inner node
  };
  void build(std::int32_t node, std::int32_t begin, std::int32_t end);
  /// Triangles in the boxes that are wanted(), until done() says so. Not for an empty tree.
  template <class Wanted, class Done>
  bool visit(const Wanted& wanted, const Done& done) const;

  std::vector<Triangle> triangles_;
  std::vector<std::int32_t> slotOfRow_;
  std::vector<Node> nodes_;
};

/// The point of triangle abc nearest to p [Ericson 2005, 5.1.5]; degenerate triangles are segments
/// or points.
[[nodiscard]] mesh::Vector3 closestOnTriangle(const mesh::Vector3& p, const mesh::Vector3& a,
                                              const mesh::Vector3& b, const mesh::Vector3& c);

}  // namespace ecorche::domain
