#include "support/generated_domain.h"

#include <ecorche/core/contract.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

namespace ecorche::test {

using domain::BoundaryTag;
using domain::Domain;
using mesh::TetMesh;
using mesh::Vector3;

namespace {

double signedUnit(std::mt19937_64& random) {  // in (−1, 1), the same on every platform
  return static_cast<double>(random() >> 11) * 0x1p-52 - 1.0;
}

void orient(TetMesh& mesh) {
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    if (mesh::signedVolume(mesh, t) < 0.0) std::swap(mesh.T(t, 2), mesh.T(t, 3));
  }
}

}  // namespace

TetMesh kuhnGrid(const Grid& grid) {
  const Eigen::Array3i n = grid.cells;
  const auto id = [&](int x, int y, int z) { return (z * (n.y() + 1) + y) * (n.x() + 1) + x; };
  std::mt19937_64 random(grid.seed);
  const Vector3 cell = (grid.hi - grid.lo).array() / n.cast<double>();
  TetMesh mesh;
  mesh.V.resize((n + 1).prod(), 3);
  for (int z = 0; z <= n.z(); ++z) {
    for (int y = 0; y <= n.y(); ++y) {
      for (int x = 0; x <= n.x(); ++x) {
        const Eigen::Array3i i(x, y, z);
        Vector3 p = grid.lo.array() + i.cast<double>() * cell.array();
        if ((i > 0).all() && (i < n).all()) {
          for (int k = 0; k < 3; ++k) p[k] += grid.jitter * signedUnit(random) * cell[k];
        }
        mesh.V.row(id(x, y, z)) = p.transpose();
      }
    }
  }
  static constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                        {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  mesh.T.resize(6 * n.prod(), 4);
  Eigen::Index t = 0;
  for (int z = 0; z < n.z(); ++z) {
    for (int y = 0; y < n.y(); ++y) {
      for (int x = 0; x < n.x(); ++x) {
        const Eigen::Array3i flip(grid.mirrored && 2 * x < n.x(), grid.mirrored && 2 * y < n.y(),
                                  0);
        for (const auto& order : kOrders) {
          Eigen::Array3i at(0, 0, 0);
          for (int k = 0; k < 4; ++k) {
            const Eigen::Array3i c = Eigen::Array3i(x, y, z) + (at - flip).abs();
            mesh.T(t, k) = id(c.x(), c.y(), c.z());
            if (k < 3) at[order[k]] = 1;
          }
          ++t;
        }
      }
    }
  }
  orient(mesh);
  return mesh;
}

Domain domainOf(TetMesh mesh, const FaceTagger& tag) {
  Domain out;
  out.mesh = std::move(mesh);
  out.neighbours = mesh::tetAdjacency(out.mesh.T).neighbours;
  const mesh::TetBoundary boundary = mesh::tetBoundary(out.mesh.T, out.neighbours);
  out.boundaryF = boundary.F;
  out.boundaryTet = boundary.tet;
  out.onSkin.assign(static_cast<std::size_t>(out.mesh.V.rows()), 0);
  mesh::Box skin;
  for (Eigen::Index f = 0; f < out.boundaryF.rows(); ++f) {
    const auto at = [&](int k) { return Vector3(out.mesh.V.row(out.boundaryF(f, k)).transpose()); };
    const Vector3 normal = (at(1) - at(0)).cross(at(2) - at(0)).normalized();
    out.boundaryTag.push_back(tag((at(0) + at(1) + at(2)) / 3.0, normal));
    if (out.boundaryTag.back().kind != BoundaryTag::Kind::Skin) continue;
    for (int k = 0; k < 3; ++k) {
      out.onSkin[static_cast<std::size_t>(out.boundaryF(f, k))] = 1;
      skin.add(at(k));
    }
  }
  out.skinDiagonal = skin.diagonal();
  out.volume = mesh::signedVolumes(out.mesh).sum();
  return out;
}

BoundaryTag allSkin(const Vector3&, const Vector3&) { return {}; }

Domain boxDomain(const Grid& grid) { return domainOf(kuhnGrid(grid), allSkin); }

Domain cylinderDomain(double radius, double length, int cellsAcross, std::uint64_t seed) {
  Grid grid;
  const int along =
      std::max(1, static_cast<int>(std::lround(cellsAcross * length / (2.0 * radius))));
  grid.cells = {cellsAcross, cellsAcross, along};
  grid.lo = {-radius, -radius, 0.0};
  grid.hi = {radius, radius, length};
  grid.jitter = seed == 0 ? 0.0 : 0.2;
  grid.seed = seed;
  grid.mirrored = true;
  TetMesh mesh = kuhnGrid(grid);

  // Squares about the axis become circles, more and more so towards the side: the middle keeps its
  // even grid
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) {
    const Eigen::Vector2d p = mesh.V.row(v).head<2>().transpose();
    const double square = p.cwiseAbs().maxCoeff() / radius;
    if (square == 0.0) continue;
    const double blend = std::clamp((square - 0.3) / 0.7, 0.0, 1.0);
    const double onCircle = square * radius / p.norm();
    mesh.V.row(v).head<2>() *= 1.0 + blend * (onCircle - 1.0);
  }
  Domain out = domainOf(std::move(mesh), [&](const Vector3&, const Vector3& normal) -> BoundaryTag {
    if (std::abs(normal.z()) < 0.5) return {};
    return {BoundaryTag::Kind::CutPlane, normal.z() < 0.0 ? 0 : 1};
  });
  out.cutPlaneNames = {"bottom", "top"};
  return out;
}

Domain shellDomain(double inner, double outer, int fineness) {
  // Icosahedron, its faces cut into fineness² triangles and pushed onto the unit sphere
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  const std::array<Vector3, 12> corner = {
      Vector3(-1, g, 0), Vector3(1, g, 0), Vector3(-1, -g, 0), Vector3(1, -g, 0),
      Vector3(0, -1, g), Vector3(0, 1, g), Vector3(0, -1, -g), Vector3(0, 1, -g),
      Vector3(g, 0, -1), Vector3(g, 0, 1), Vector3(-g, 0, -1), Vector3(-g, 0, 1)};
  static constexpr int kFaces[20][3] = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  std::vector<Vector3> sphere;
  std::map<std::array<std::int64_t, 3>, int> known;
  const auto pointId = [&](const Vector3& p) {
    const Vector3 unit = p.normalized();
    const Eigen::Array3d rounded = (unit.array() * 1e7).round();
    const auto [where, fresh] = known.try_emplace(
        {static_cast<std::int64_t>(rounded.x()), static_cast<std::int64_t>(rounded.y()),
         static_cast<std::int64_t>(rounded.z())},
        static_cast<int>(sphere.size()));
    if (fresh) sphere.push_back(unit);
    return where->second;
  };
  std::vector<std::array<int, 3>> triangles;
  for (const auto& f : kFaces) {
    const auto at = [&](int i, int j) {
      const double a = static_cast<double>(i) / fineness;
      const double b = static_cast<double>(j) / fineness;
      return pointId((1.0 - a - b) * corner[static_cast<std::size_t>(f[0])] +
                     a * corner[static_cast<std::size_t>(f[1])] +
                     b * corner[static_cast<std::size_t>(f[2])]);
    };
    for (int i = 0; i < fineness; ++i) {
      for (int j = 0; i + j < fineness; ++j) {
        triangles.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
        if (i + j + 1 < fineness)
          triangles.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
  }

  // Layers of prisms, each split along diagonals that rise from the lower to the higher point of
  // the sphere
  const int layers = std::max(1, static_cast<int>(std::lround(fineness * (outer - inner) / outer)));
  const auto count = static_cast<int>(sphere.size());
  TetMesh mesh;
  mesh.V.resize(static_cast<Eigen::Index>(count) * (layers + 1), 3);
  for (int layer = 0; layer <= layers; ++layer) {
    const double r = inner * std::pow(outer / inner, static_cast<double>(layer) / layers);
    for (int p = 0; p < count; ++p) {
      mesh.V.row(layer * count + p) = r * sphere[static_cast<std::size_t>(p)].transpose();
    }
  }
  mesh.T.resize(static_cast<Eigen::Index>(triangles.size()) * 3 * layers, 4);
  Eigen::Index t = 0;
  for (auto triangle : triangles) {
    std::ranges::sort(triangle);
    const auto [a, b, c] = triangle;
    for (int low = 0; low < layers * count; low += count) {
      const int high = low + count;
      mesh.T.row(t++) << a + low, b + low, c + low, c + high;
      mesh.T.row(t++) << a + low, b + low, b + high, c + high;
      mesh.T.row(t++) << a + low, a + high, b + high, c + high;
    }
  }
  orient(mesh);
  Domain out =
      domainOf(std::move(mesh), [&](const Vector3& centroid, const Vector3& normal) -> BoundaryTag {
        return {centroid.dot(normal) > 0.0 ? BoundaryTag::Kind::Skin : BoundaryTag::Kind::Bone, 0};
      });
  out.boneNames = {"ball"};
  return out;
}

Domain moved(const Domain& domain, const Eigen::Matrix3d& rotation, double scale,
             const Vector3& translation) {
  Domain out = domain;
  out.mesh.V = (scale * (domain.mesh.V * rotation.transpose())).rowwise() + translation.transpose();
  out.skinDiagonal = scale * domain.skinDiagonal;
  out.volume = scale * scale * scale * domain.volume;
  return out;
}

}  // namespace ecorche::test
