#include "fiber/shapes.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

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

namespace {

// A shape before it is labelled, with the grid coordinates of its vertices.
struct GridShape {
  Shape shape;
  std::vector<Vector3> grid;
};

void tagBoundary(const ShapeRecipe& recipe, const std::vector<Vector3>& grid,
                 const mesh::Triangles& F, std::vector<domain::BoundaryTag>& tags) {
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    Vector3 g = Vector3::Zero();
    for (int c = 0; c < 3; ++c) g += grid[static_cast<std::size_t>(F(f, c))] / 3.0;
    tags.push_back(recipe.tag ? recipe.tag(g) : defaultTag(g));
  }
}

GridShape makeGrid(const ShapeRecipe& recipe, double jitter) {
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

  // Off the walls only, so that the body keeps its shape
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> move(-jitter, jitter);
  for (Vector3& g : grid) {
    const Vector3 step(move(random) / nx, move(random) / ny, move(random) / nz);
    if ((g.array() > 1e-9).all() && (g.array() < 1.0 - 1e-9).all()) g += step;
  }

  GridShape out;
  Shape& shape = out.shape;
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
  tagBoundary(recipe, grid, d.boundaryF, d.boundaryTag);
  for (std::size_t f = 0; f < d.boundaryTag.size(); ++f) {
    if (d.boundaryTag[f].kind != domain::BoundaryTag::Kind::Skin) continue;
    for (int c = 0; c < 3; ++c)
      d.onSkin[static_cast<std::size_t>(d.boundaryF(static_cast<Eigen::Index>(f), c))] = 1;
  }
  out.grid = std::move(grid);
  return out;
}

// A convex body with two triangles and three quads between them, cut into tets from its vertex of
// lowest id; faces are cut from theirs, so that neighbours agree.
void pullWedge(const std::array<std::int32_t, 3>& p, const std::array<std::int32_t, 3>& q,
               std::vector<std::array<std::int32_t, 4>>& tets) {
  const std::int32_t apex = std::min(*std::ranges::min_element(p), *std::ranges::min_element(q));
  const auto cone = [&](std::vector<std::int32_t> face) {
    if (std::ranges::find(face, apex) != face.end()) return;
    std::ranges::rotate(face, std::ranges::min_element(face));
    for (std::size_t k = 1; k + 1 < face.size(); ++k)
      tets.push_back({apex, face[0], face[k], face[k + 1]});
  };
  cone({p[0], p[1], p[2]});
  cone({q[0], q[1], q[2]});
  for (std::size_t k = 0; k < 3; ++k) cone({p[k], p[(k + 1) % 3], q[(k + 1) % 3], q[k]});
}

}  // namespace

Shape makeShape(const ShapeRecipe& recipe) {
  auto [shape, grid] = makeGrid(recipe, 0.0);
  const domain::Domain& d = shape.domain;
  const mesh::TetMesh& mesh = d.mesh;
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

Shape makeCutShape(const ShapeRecipe& recipe, const std::function<double(const Vector3&)>& inside,
                   double clamp, double jitter) {
  auto [shape, grid] = makeGrid(recipe, jitter);
  const mesh::TetMesh& whole = shape.domain.mesh;
  const auto vertexCount = static_cast<std::int32_t>(whole.V.rows());
  std::vector<double> f(static_cast<std::size_t>(vertexCount));
  for (std::int32_t v = 0; v < vertexCount; ++v)
    f[static_cast<std::size_t>(v)] = inside(whole.V.row(v).transpose());
  const auto isIn = [&](std::int32_t v) { return f[static_cast<std::size_t>(v)] > 0.0; };

  // One new vertex per edge that changes sides
  envelope::Anatomy& a = shape.anatomy;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> crossings;
  std::vector<Vector3> points;
  const auto crossing = [&](std::int32_t u, std::int32_t w) {
    if (u > w) std::swap(u, w);
    const auto [at, fresh] =
        crossings.emplace(std::pair(u, w), vertexCount + static_cast<std::int32_t>(points.size()));
    if (fresh) {
      const double fu = f[static_cast<std::size_t>(u)];
      const double s = std::clamp(fu / (fu - f[static_cast<std::size_t>(w)]), clamp, 1.0 - clamp);
      points.emplace_back((1.0 - s) * whole.V.row(u).transpose() + s * whole.V.row(w).transpose());
      grid.push_back((1.0 - s) * grid[static_cast<std::size_t>(u)] +
                     s * grid[static_cast<std::size_t>(w)]);
      a.origin.push_back({{u, w, -1, -1}, {1.0 - s, s, 0.0, 0.0}});
    }
    return at->second;
  };

  std::vector<std::array<std::int32_t, 4>> tets;
  const auto label = [&](bool muscle, Eigen::Index parent) {
    while (a.label.size() < tets.size()) {
      a.label.push_back(muscle ? kFirstMuscle : kFat);
      a.parentTet.push_back(static_cast<std::int32_t>(parent));
    }
  };
  for (Eigen::Index t = 0; t < whole.T.rows(); ++t) {
    std::vector<std::int32_t> in;
    std::vector<std::int32_t> out;
    for (int k = 0; k < 4; ++k) (isIn(whole.T(t, k)) ? in : out).push_back(whole.T(t, k));
    if (in.empty() || out.empty()) {
      tets.push_back({whole.T(t, 0), whole.T(t, 1), whole.T(t, 2), whole.T(t, 3)});
      label(out.empty(), t);
      continue;
    }
    for (const bool muscle : {true, false}) {
      const auto& own = muscle ? in : out;
      const auto& other = muscle ? out : in;
      if (own.size() == 1) {
        tets.push_back({own[0], crossing(own[0], other[0]), crossing(own[0], other[1]),
                        crossing(own[0], other[2])});
      } else if (own.size() == 2) {
        pullWedge({own[0], crossing(own[0], other[0]), crossing(own[0], other[1])},
                  {own[1], crossing(own[1], other[0]), crossing(own[1], other[1])}, tets);
      } else {
        pullWedge(
            {own[0], own[1], own[2]},
            {crossing(own[0], other[0]), crossing(own[1], other[0]), crossing(own[2], other[0])},
            tets);
      }
      label(muscle, t);
    }
  }

  a.mesh.V.resize(vertexCount + static_cast<Eigen::Index>(points.size()), 3);
  a.mesh.V.topRows(vertexCount) = whole.V;
  for (std::size_t k = 0; k < points.size(); ++k)
    a.mesh.V.row(vertexCount + static_cast<Eigen::Index>(k)) = points[k].transpose();
  a.mesh.T.resize(static_cast<Eigen::Index>(tets.size()), 4);
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const auto row = static_cast<Eigen::Index>(t);
    for (std::size_t c = 0; c < 4; ++c) a.mesh.T(row, static_cast<Eigen::Index>(c)) = tets[t][c];
    if (mesh::signedVolume(a.mesh, row) < 0.0) std::swap(a.mesh.T(row, 2), a.mesh.T(row, 3));
  }
  a.neighbours = mesh::tetAdjacency(a.mesh.T).neighbours;
  const mesh::TetBoundary boundary = mesh::tetBoundary(a.mesh.T, a.neighbours);
  a.boundaryF = boundary.F;
  a.boundaryTet = boundary.tet;
  tagBoundary(recipe, grid, a.boundaryF, a.boundaryTag);
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
