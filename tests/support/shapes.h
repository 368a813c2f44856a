#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

namespace ecorche::test {

/// Closed box with 12 triangles facing outward.
inline mesh::SurfaceMesh box(const mesh::Vector3& lo, const mesh::Vector3& hi) {
  mesh::SurfaceMesh m;
  m.name = "box";
  m.V.resize(8, 3);
  for (int v = 0; v < 8; ++v) {
    for (int k = 0; k < 3; ++k) m.V(v, k) = ((v >> k) & 1) != 0 ? hi[k] : lo[k];
  }
  m.F.resize(12, 3);
  m.F << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6,
      1, 3, 5, 3, 7, 5;
  return m;
}

/// Icosahedron cut into four, `levels` times, on a sphere; faces outward.
inline mesh::SurfaceMesh sphere(const mesh::Vector3& centre, double radius, int levels) {
  const double t = std::numbers::phi;
  std::vector<mesh::Vector3> V = {{-1, t, 0}, {1, t, 0}, {-1, -t, 0}, {1, -t, 0},
                                  {0, -1, t}, {0, 1, t}, {0, -1, -t}, {0, 1, -t},
                                  {t, 0, -1}, {t, 0, 1}, {-t, 0, -1}, {-t, 0, 1}};
  using Face = std::array<int, 3>;
  std::vector<Face> F = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                         {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                         {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                         {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto between = [&](int a, int b) {
      const auto [at, isNew] = middle.try_emplace(std::minmax(a, b), int(V.size()));
      if (isNew) V.push_back(0.5 * (V[std::size_t(a)] + V[std::size_t(b)]));
      return at->second;
    };
    std::vector<Face> finer;
    for (const auto& [a, b, c] : F) {
      const int ab = between(a, b), bc = between(b, c), ca = between(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    F = std::move(finer);
  }
  mesh::SurfaceMesh m;
  m.name = "sphere";
  m.V.resize(Eigen::Index(V.size()), 3);
  for (std::size_t v = 0; v < V.size(); ++v) {
    m.V.row(Eigen::Index(v)) = (centre + radius * V[v].normalized()).transpose();
  }
  m.F.resize(Eigen::Index(F.size()), 3);
  for (std::size_t f = 0; f < F.size(); ++f) m.F.row(Eigen::Index(f)) << F[f][0], F[f][1], F[f][2];
  return m;
}

/// The walls of rooms made of unit cubes, each wall once, corners shared: walls of what is no room
/// face out of the rooms, those between two rooms look along an axis.
/// @param roomAt  the room that the cube at x, y, z belongs to; 0: none
template <class RoomAt>
mesh::SurfaceMesh rooms(int nx, int ny, int nz, const RoomAt& roomAt) {
  const std::array<int, 3> n{nx, ny, nz};
  std::map<std::array<int, 3>, int> number;
  std::vector<std::array<int, 3>> faces;
  const auto room = [&](const std::array<int, 3>& c) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (c[k] < 0 || c[k] >= n[k]) return 0;
    }
    return roomAt(c[0], c[1], c[2]);
  };
  const auto wall = [&](const std::array<int, 3>& cell, std::size_t axis) {
    std::array<int, 3> before = cell;
    --before[axis];
    const int behind = room(before), ahead = room(cell);
    if (behind == ahead) return;
    // Counter-clockwise for one who looks against the axis
    std::array<int, 4> corner{};
    for (int k = 0; k < 4; ++k) {
      std::array<int, 3> at = cell;
      at[(axis + 1) % 3] += k == 1 || k == 2;
      at[(axis + 2) % 3] += k >= 2;
      corner[std::size_t(k)] = number.try_emplace(at, int(number.size())).first->second;
    }
    if (behind == 0) std::swap(corner[1], corner[3]);
    faces.push_back({corner[0], corner[1], corner[2]});
    faces.push_back({corner[0], corner[2], corner[3]});
  };
  for (int x = 0; x <= nx; ++x) {
    for (int y = 0; y <= ny; ++y) {
      for (int z = 0; z <= nz; ++z) {
        for (std::size_t axis = 0; axis < 3; ++axis) wall({x, y, z}, axis);
      }
    }
  }
  mesh::SurfaceMesh m;
  m.name = "rooms";
  m.V.resize(Eigen::Index(number.size()), 3);
  for (const auto& [at, v] : number) m.V.row(v) << at[0], at[1], at[2];
  m.F.resize(Eigen::Index(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    m.F.row(Eigen::Index(f)) << faces[f][0], faces[f][1], faces[f][2];
  return m;
}

/// Torus about the z axis, faces outward; `around` and `across` segments.
inline mesh::SurfaceMesh torus(double radius, double tube, int around, int across) {
  mesh::SurfaceMesh m;
  m.name = "torus";
  m.V.resize(around * across, 3);
  m.F.resize(2 * around * across, 3);
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around;
      const double w = 2 * std::numbers::pi * j / across;
      const double r = radius + tube * std::cos(w);
      m.V.row(i * across + j) << r * std::cos(u), r * std::sin(u), tube * std::sin(w);
      const int a = i * across + j, b = (i + 1) % around * across + j;
      const int c = (i + 1) % around * across + (j + 1) % across, d = i * across + (j + 1) % across;
      m.F.row(2 * (i * across + j)) << a, b, c;
      m.F.row(2 * (i * across + j) + 1) << a, c, d;
    }
  }
  return m;
}

}  // namespace ecorche::test
