#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

namespace ecorche::test {

/// A ball of 20·4^n triangles whose points are then moved by `shape`.
template <class Shape>
mesh::SurfaceMesh ball(int subdivisions, const Shape& shape) {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  std::vector<mesh::Vector3> V = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                  {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                  {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<int, 3>> F = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                       {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                       {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                       {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (auto& v : V) v.normalize();
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [at, fresh] = middle.emplace(std::minmax(a, b), static_cast<int>(V.size()));
      if (fresh)
        V.push_back((V[static_cast<std::size_t>(a)] + V[static_cast<std::size_t>(b)]).normalized());
      return at->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : F) {
      const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    F = std::move(finer);
  }
  mesh::SurfaceMesh out;
  out.name = "ball";
  out.V.resize(static_cast<Eigen::Index>(V.size()), 3);
  out.F.resize(static_cast<Eigen::Index>(F.size()), 3);
  for (std::size_t v = 0; v < V.size(); ++v)
    out.V.row(static_cast<Eigen::Index>(v)) = shape(V[v]).transpose();
  for (std::size_t f = 0; f < F.size(); ++f) {
    for (int k = 0; k < 3; ++k)
      out.F(static_cast<Eigen::Index>(f), k) = F[f][static_cast<std::size_t>(k)];
  }
  return out;
}

}  // namespace ecorche::test
