#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace ecorche::mesh {

/// A face by itself: its corners, and numbers that say which of them it shares with others.
struct FaceCorners {
  std::array<std::int32_t, 3> vertex;
  std::array<Vector3, 3> at;
};

/// Row `face` of F.
[[nodiscard]] FaceCorners faceCorners(const Positions& V, const Triangles& F, Eigen::Index face);

/// No area. Exact.
[[nodiscard]] bool isDegenerate(const FaceCorners& face);

/// Do two faces meet elsewhere than in the vertices and edges they share? Exact. Never for faces
/// over the same three vertices; not for degenerate faces.
[[nodiscard]] bool facesMeet(const FaceCorners& f, const FaceCorners& g);

/// Pairs of faces that meet elsewhere than in the vertices and edges they share, each pair once,
/// ascending. Exact. Faces over the same three vertices and faces without area are left out.
[[nodiscard]] std::vector<std::pair<std::int32_t, std::int32_t>> selfIntersections(
    const Positions& V, const Triangles& F);

}  // namespace ecorche::mesh
