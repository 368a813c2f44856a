#include <ecorche/engine/centreline.h>
#include <ecorche/mesh/disjoint_sets.h>
#include <ecorche/mesh/surface_query.h>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

namespace ecorche::engine {

using mesh::Vector3;

namespace {

constexpr double kOnPatchRel = 0.002;  // of the muscle's diagonal, beyond its nearest vertex
constexpr int kSections = 80;
constexpr int kPoints = 100;
constexpr int kSmoothings = 6;

Vector3 corner(const mesh::SurfaceMesh& mesh, Eigen::Index f, int k) {
  return mesh.V.row(mesh.F(f, k)).transpose();
}

std::vector<bool> verticesOn(const mesh::SurfaceMesh& muscle, const mesh::SurfaceMesh& patch) {
  const mesh::SurfaceQuery query(patch);
  std::vector<double> distance;
  for (Eigen::Index v = 0; v < muscle.V.rows(); ++v)
    distance.push_back(query.distance(muscle.V.row(v).transpose()));
  const double reach =
      *std::ranges::min_element(distance) + kOnPatchRel * mesh::boundingBox(muscle).diagonal();
  std::vector<bool> out;
  for (const double d : distance) out.push_back(d <= reach);
  return out;
}

// Cotangents of the corner angles, opposite to each edge; never below a little: obtuse corners
// would turn the flow around.
std::array<double, 3> weightsOf(const mesh::SurfaceMesh& mesh, Eigen::Index f) {
  std::array<double, 3> out{};
  for (int k = 0; k < 3; ++k) {
    const Vector3 a = corner(mesh, f, (k + 1) % 3) - corner(mesh, f, k);
    const Vector3 b = corner(mesh, f, (k + 2) % 3) - corner(mesh, f, k);
    const double area = a.cross(b).norm();
    out[static_cast<std::size_t>(k)] =
        area > 0.0 ? std::clamp(0.5 * a.dot(b) / area, 1e-3, 1e3) : 1e-3;
  }
  return out;
}

// Harmonic on the vertices: 0 on one patch, 1 on the other. Nothing where no component has both.
std::optional<Eigen::VectorXd> flowFrom(const mesh::SurfaceMesh& mesh,
                                        const std::vector<bool>& from,
                                        const std::vector<bool>& to) {
  const auto count = static_cast<std::size_t>(mesh.V.rows());
  mesh::DisjointSets sets(count);
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) sets.unite(mesh.F(f, k), mesh.F(f, (k + 1) % 3));
  }
  std::map<std::int32_t, int> held;  // by component: 1 from, 2 to
  for (std::size_t v = 0; v < count; ++v) {
    const std::int32_t root = sets.root(static_cast<std::int32_t>(v));
    held[root] |= (from[v] ? 1 : 0) | (to[v] ? 2 : 0);
  }
  Eigen::VectorXd u = Eigen::VectorXd::Constant(mesh.V.rows(), std::nan(""));
  std::vector<Eigen::Index> row(count, -1);
  Eigen::Index rows = 0;
  for (std::size_t v = 0; v < count; ++v) {
    if (held[sets.root(static_cast<std::int32_t>(v))] != 3) continue;
    const auto at = static_cast<Eigen::Index>(v);
    if (from[v]) {
      u[at] = 0.0;
    } else if (to[v]) {
      u[at] = 1.0;
    } else {
      row[v] = rows++;
    }
  }
  if (rows == 0) return std::nullopt;
  std::vector<Eigen::Triplet<double>> entries;
  Eigen::VectorXd right = Eigen::VectorXd::Zero(rows);
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    const std::array<double, 3> weights = weightsOf(mesh, f);
    for (int k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(mesh.F(f, (k + 1) % 3));
      const auto b = static_cast<std::size_t>(mesh.F(f, (k + 2) % 3));
      const double w = weights[static_cast<std::size_t>(k)];
      for (const auto& [i, j] : {std::pair(a, b), std::pair(b, a)}) {
        if (row[i] < 0) continue;
        entries.emplace_back(row[i], row[i], w);
        if (row[j] >= 0) {
          entries.emplace_back(row[i], row[j], -w);
        } else {
          right[row[i]] += w * u[static_cast<Eigen::Index>(j)];
        }
      }
    }
  }
  Eigen::SparseMatrix<double> matrix(rows, rows);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success) return std::nullopt;
  const Eigen::VectorXd x = factor.solve(right);
  for (std::size_t v = 0; v < count; ++v) {
    if (row[v] >= 0) u[static_cast<Eigen::Index>(v)] = x[row[v]];
  }
  return u;
}

// Where a value is taken on one connected run of faces.
struct Loop {
  std::vector<std::pair<Vector3, Vector3>> pieces;  // larger values to their left
  double flow = 0.0;

  [[nodiscard]] Vector3 middle() const {
    Vector3 sum = Vector3::Zero();
    double length = 0.0;
    for (const auto& [a, b] : pieces) {
      sum += 0.5 * (b - a).norm() * (a + b);
      length += (b - a).norm();
    }
    return length > 0.0 ? Vector3(sum / length) : pieces.front().first;
  }
  // Of the disc that it spans, as a fan about the middle of its line
  void measure(Vector3& centre, double& area) const {
    const Vector3 o = middle();
    Vector3 normal = Vector3::Zero();
    for (const auto& [a, b] : pieces) normal += 0.5 * (a - o).cross(b - o);
    area = normal.norm();
    centre = o;
    double line = 0.0;
    for (const auto& [a, b] : pieces) line += (b - a).norm();
    if (area <= 1e-3 * line * line) return;  // hardly a disc: the fan's parts cancel
    const Vector3 n = normal / area;
    Vector3 sum = Vector3::Zero();
    for (const auto& [a, b] : pieces)
      sum += (a - o).cross(b - o).dot(n) / 6.0 * ((a - o) + (b - o));
    centre = o + sum / area;
  }
};

std::optional<Loop> sectionAt(const mesh::SurfaceMesh& mesh, const Eigen::VectorXd& u,
                              double level) {
  struct Piece {
    Vector3 a, b;
    std::int32_t edgeA, edgeB;
    double flow;
  };
  std::vector<Piece> pieces;
  std::map<std::pair<int, int>, std::int32_t> edges;
  const auto edgeOf = [&](int a, int b) {
    const std::pair<int, int> key = std::minmax(a, b);
    return edges.try_emplace(key, static_cast<std::int32_t>(edges.size())).first->second;
  };
  for (Eigen::Index f = 0; f < mesh.F.rows(); ++f) {
    std::array<double, 3> value{};
    for (int k = 0; k < 3; ++k) value[static_cast<std::size_t>(k)] = u[mesh.F(f, k)];
    if (std::ranges::any_of(value, [](double x) { return std::isnan(x); })) continue;
    std::array<std::pair<Vector3, std::int32_t>, 2> cut{};
    std::size_t cuts = 0;
    bool rising = false;  // along the first edge that is cut
    for (int k = 0; k < 3; ++k) {
      const double p = value[static_cast<std::size_t>(k)] - level;
      const double q = value[static_cast<std::size_t>((k + 1) % 3)] - level;
      if ((p < 0.0) == (q < 0.0)) continue;
      if (cuts == 0) rising = p < 0.0;
      const double t = p / (p - q);
      cut[cuts++] = {(1.0 - t) * corner(mesh, f, k) + t * corner(mesh, f, (k + 1) % 3),
                     edgeOf(mesh.F(f, k), mesh.F(f, (k + 1) % 3))};
    }
    if (cuts != 2) continue;
    const Vector3 normal =
        (corner(mesh, f, 1) - corner(mesh, f, 0)).cross(corner(mesh, f, 2) - corner(mesh, f, 0));
    const double twice = normal.norm();
    double flow = 0.0;
    if (twice > 0.0) {
      Vector3 gradient = Vector3::Zero();
      for (int k = 0; k < 3; ++k)
        gradient += value[static_cast<std::size_t>(k)] *
                    normal.cross(corner(mesh, f, (k + 2) % 3) - corner(mesh, f, (k + 1) % 3)) /
                    (twice * twice);
      flow = gradient.norm() * (cut[1].first - cut[0].first).norm();
    }
    if (!rising) std::swap(cut[0], cut[1]);
    pieces.push_back({cut[0].first, cut[1].first, cut[0].second, cut[1].second, flow});
  }
  if (pieces.empty()) return std::nullopt;
  mesh::DisjointSets sets(edges.size());
  for (const Piece& piece : pieces) sets.unite(piece.edgeA, piece.edgeB);
  std::map<std::int32_t, Loop> loops;
  for (const Piece& piece : pieces) {
    Loop& loop = loops[sets.root(piece.edgeA)];
    loop.pieces.emplace_back(piece.a, piece.b);
    loop.flow += piece.flow;
  }
  const auto most =
      std::ranges::max_element(loops, {}, [](const auto& entry) { return entry.second.flow; });
  return most->second;
}

Vector3 middleOf(const mesh::SurfaceMesh& patch) {
  Vector3 sum = Vector3::Zero();
  double area = 0.0;
  for (Eigen::Index f = 0; f < patch.F.rows(); ++f) {
    const Vector3 a = corner(patch, f, 0), b = corner(patch, f, 1), c = corner(patch, f, 2);
    const double part = (b - a).cross(c - a).norm();
    sum += part / 3.0 * (a + b + c);
    area += part;
  }
  return area > 0.0 ? Vector3(sum / area) : Vector3(patch.V.colwise().mean().transpose());
}

std::vector<Vector3> atEvenSteps(const std::vector<Vector3>& line, int steps) {
  std::vector<double> s{0.0};
  for (std::size_t i = 1; i < line.size(); ++i)
    s.push_back(s.back() + (line[i] - line[i - 1]).norm());
  std::vector<Vector3> out;
  std::size_t piece = 1;
  for (int k = 0; k <= steps; ++k) {
    const double at = s.back() * k / steps;
    while (piece + 1 < line.size() && s[piece] < at) ++piece;
    const double gap = s[piece] - s[piece - 1];
    const double t = gap > 0.0 ? std::clamp((at - s[piece - 1]) / gap, 0.0, 1.0) : 0.0;
    out.push_back((1.0 - t) * line[piece - 1] + t * line[piece]);
  }
  return out;
}

}  // namespace

std::optional<Centreline> centrelineOf(const mesh::SurfaceMesh& muscle,
                                       const mesh::SurfaceMesh& from, const mesh::SurfaceMesh& to) {
  if (muscle.empty() || from.empty() || to.empty()) return std::nullopt;
  const auto u = flowFrom(muscle, verticesOn(muscle, from), verticesOn(muscle, to));
  if (!u) return std::nullopt;
  Centreline out;
  std::vector<Vector3> line{middleOf(from)};
  for (int k = 0; k < kSections; ++k) {
    const auto loop = sectionAt(muscle, *u, (k + 0.5) / kSections);
    if (!loop) return std::nullopt;
    Vector3 centre;
    double area = 0.0;
    loop->measure(centre, area);
    line.push_back(centre);
    if (k == kSections / 2) out.radius = std::sqrt(area / std::numbers::pi);
  }
  line.push_back(middleOf(to));

  // Sections follow the triangles: even steps, then each point to the mean of itself and its
  // neighbours
  out.points = atEvenSteps(line, kPoints);
  for (int round = 0; round < kSmoothings; ++round) {
    const std::vector<Vector3> before = out.points;
    for (std::size_t i = 1; i + 1 < before.size(); ++i)
      out.points[i] = 0.25 * before[i - 1] + 0.5 * before[i] + 0.25 * before[i + 1];
  }
  const mesh::SurfaceQuery query(muscle);
  for (const Vector3& p : out.points)
    out.inside += (query.inside(p) ? 1.0 : 0.0) / static_cast<double>(out.points.size());
  return out;
}

}  // namespace ecorche::engine
