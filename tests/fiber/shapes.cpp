#include "fiber/shapes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ecorche::test {

using mesh::Vector3;

namespace {

domain::BoundaryTag defaultTag(const Vector3& g) {
  using Kind = domain::BoundaryTag::Kind;
  if (g.z() < 1e-9) return {Kind::Bone, 0};
  if (g.z() > 1.0 - 1e-9) return {Kind::Bone, 1};
  return {Kind::Skin, 0};
}

// Six tets about the diagonal of a cube, one per order of the axes [Kuhn].
constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};

}  // namespace

Vector3 roundedSection(const Vector3& g) {
  const double x = 2.0 * g.x() - 1.0;
  const double y = 2.0 * g.y() - 1.0;
  // Short of a true disc, whose corner cells would be flat
  constexpr double kRound = 0.85;
  const Vector3 disc(x * std::sqrt(1.0 - 0.5 * y * y), y * std::sqrt(1.0 - 0.5 * x * x), 0.0);
  const Vector3 square = 0.8 * Vector3(x, y, 0.0);
  return kRound * disc + (1.0 - kRound) * square;
}

Shape makeShape(const ShapeRecipe& recipe) {
  const auto [nx, ny, nz] = recipe.cells;
  const auto id = [&](int i, int j, int k) { return (k * (ny + 1) + j) * (nx + 1) + i; };
  std::vector<Vector3> grid(static_cast<std::size_t>((nx + 1) * (ny + 1) * (nz + 1)));
  for (int k = 0; k <= nz; ++k) {
    for (int j = 0; j <= ny; ++j) {
      for (int i = 0; i <= nx; ++i) {
        grid[static_cast<std::size_t>(id(i, j, k))] = {double(i) / nx, double(j) / ny,
                                                       double(k) / nz};
      }
    }
  }

  Shape shape;
  mesh::TetMesh& mesh = shape.domain.mesh;
  mesh.V.resize(static_cast<Eigen::Index>(grid.size()), 3);
  for (std::size_t v = 0; v < grid.size(); ++v) {
    mesh.V.row(static_cast<Eigen::Index>(v)) = recipe.map(grid[v]).transpose();
  }
  mesh.T.resize(6 * nx * ny * nz, 4);
  Eigen::Index t = 0;
  for (int k = 0; k < nz; ++k) {
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        for (const auto& order : kOrders) {
          std::array<int, 3> at{i, j, k};
          std::array<std::int32_t, 4> v{id(at[0], at[1], at[2])};
          for (std::size_t s = 0; s < 3; ++s) {
            ++at[static_cast<std::size_t>(order[s])];
            v[s + 1] = id(at[0], at[1], at[2]);
          }
          for (int c = 0; c < 4; ++c) mesh.T(t, c) = v[static_cast<std::size_t>(c)];
          if (mesh::signedVolume(mesh, t) < 0.0) std::swap(mesh.T(t, 2), mesh.T(t, 3));
          ++t;
        }
      }
    }
  }

  domain::Domain& d = shape.domain;
  d.neighbours = mesh::tetAdjacency(mesh.T).neighbours;
  const mesh::TetBoundary boundary = mesh::tetBoundary(mesh.T, d.neighbours);
  d.boundaryF = boundary.F;
  d.boundaryTet = boundary.tet;
  d.onSkin.assign(grid.size(), 0);
  d.boneNames = {"upper bone", "lower bone"};
  d.skinDiagonal = mesh::boundingBox(mesh.V).diagonal();
  d.volume = mesh::signedVolumes(mesh).sum();
  for (Eigen::Index f = 0; f < d.boundaryF.rows(); ++f) {
    Vector3 g = Vector3::Zero();
    for (int c = 0; c < 3; ++c) g += grid[static_cast<std::size_t>(d.boundaryF(f, c))] / 3.0;
    d.boundaryTag.push_back(recipe.tag ? recipe.tag(g) : defaultTag(g));
    if (d.boundaryTag.back().kind != domain::BoundaryTag::Kind::Skin) continue;
    for (int c = 0; c < 3; ++c) d.onSkin[static_cast<std::size_t>(d.boundaryF(f, c))] = 1;
  }

  envelope::Anatomy& a = shape.anatomy;
  a.mesh = mesh;
  a.neighbours = d.neighbours;
  a.boundaryF = d.boundaryF;
  a.boundaryTet = d.boundaryTet;
  a.boundaryTag = d.boundaryTag;
  for (Eigen::Index tet = 0; tet < mesh.T.rows(); ++tet) {
    Vector3 g = Vector3::Zero();
    for (int c = 0; c < 4; ++c) g += 0.25 * grid[static_cast<std::size_t>(mesh.T(tet, c))];
    a.label.push_back(recipe.label(g));
    a.parentTet.push_back(static_cast<std::int32_t>(tet));
  }
  return shape;
}

tissue::CurveTissue muscleAlong(std::string name, std::vector<Vector3> points) {
  tissue::CurveTissue muscle;
  muscle.name = std::move(name);
  tissue::TissueCurve curve;
  curve.name = muscle.name;
  curve.values.assign(points.size(), 1.0);
  curve.spline = mesh::Spline(std::move(points));
  muscle.curves.push_back(std::move(curve));
  return muscle;
}

fiber::MuscleEnds boneToBone(std::size_t curves) {
  fiber::CurveEnds ends;
  ends.origin = {fiber::CurveEnd::On::Bone, 0, {}};
  ends.insertion = {fiber::CurveEnd::On::Bone, 1, {}};
  return fiber::MuscleEnds(curves, ends);
}

double angleDeg(const Vector3& a, const Vector3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

}  // namespace ecorche::test
