#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <vector>

namespace ecorche::mesh {

/// Gives equal points equal numbers, in order of first appearance. Equal is exactly equal, with 0 =
/// −0.
class VertexWelder {
 public:
  explicit VertexWelder(std::size_t expected = 0);

  /// Number of this point; a fresh one if it was never seen.
  std::int32_t add(double x, double y, double z);

  [[nodiscard]] std::int32_t count() const { return static_cast<std::int32_t>(xyz_.size() / 3); }
  [[nodiscard]] Positions positions() const;

 private:
  void grow(std::size_t slots);

  std::vector<double> xyz_;
  std::vector<std::int32_t> slots_;  // open addressing, a power of two; -1: free
};

/// The same surface with exactly equal vertices merged; order of first appearance, faces and parts
/// kept.
[[nodiscard]] SurfaceMesh weldExact(const SurfaceMesh& mesh);

}  // namespace ecorche::mesh
