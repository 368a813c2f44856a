#include <ecorche/core/contract.h>
#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/well.h>
#include <ecorche/tissue/well_radius.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

namespace ecorche::tissue {

using domain::Domain;
using mesh::Vector3;

namespace {

// From ids to their place in the order of arrival: a few hundred entries, so a small table with
// open addresses.
class Arrivals {
 public:
  Arrivals() : table_(256, {-1, -1}) {}

  // Place of the id, and whether it is new
  std::pair<std::int32_t, bool> add(std::int32_t id) {
    if (2 * count_ >= table_.size()) grow();
    std::size_t i = slot(id);
    while (table_[i].first >= 0 && table_[i].first != id) i = (i + 1) & (table_.size() - 1);
    if (table_[i].first == id) return {table_[i].second, false};
    table_[i] = {id, static_cast<std::int32_t>(count_++)};
    return {table_[i].second, true};
  }

 private:
  [[nodiscard]] std::size_t slot(std::int32_t id) const {
    return (static_cast<std::uint32_t>(id) * 2654435769U) >>
           (32 - std::bit_width(table_.size() - 1));
  }
  void grow() {
    const auto old = std::move(table_);
    table_.assign(2 * old.size(), {-1, -1});
    for (const auto& entry : old) {
      if (entry.first < 0) continue;
      std::size_t i = slot(entry.first);
      while (table_[i].first >= 0) i = (i + 1) & (table_.size() - 1);
      table_[i] = entry;
    }
  }
  std::vector<std::pair<std::int32_t, std::int32_t>> table_;
  std::size_t count_ = 0;
};

// The tets around the points, their vertices, and which of those are unknown. Lengths in reaches
// from the centre, so that units cancel.
struct Patch {
  struct Node {
    Vector3 at;
    std::int32_t vertex;
    bool free = true;  // within reach and not on the boundary
    std::int32_t row = -1;
    double line = 0.0;  // the line's field where it is prescribed
  };
  std::vector<std::array<std::int32_t, 4>> tets;  // nodes of each
  std::vector<Node> nodes;
  std::int32_t rowCount = 0;
};

// The first tets are those of the points, in their order (once each).
Patch gather(const Domain& domain, std::span<const WellPoint> points, const Vector3& centre,
             double reach, std::vector<std::int32_t>& tetOfPoint) {
  Patch patch;
  Arrivals nodeOf;
  Arrivals seen;
  std::vector<std::int32_t> queue;
  for (const WellPoint& point : points) {
    const auto [place, fresh] = seen.add(point.tet);
    if (fresh) queue.push_back(point.tet);
    tetOfPoint.push_back(place);
  }
  // The star of a vertex hangs together through faces, so tets with a corner within reach are found
  // face by face
  for (std::size_t i = 0; i < queue.size(); ++i) {
    std::array<std::int32_t, 4> n{};
    for (int k = 0; k < 4; ++k) {
      const std::int32_t v = domain.mesh.T(queue[i], k);
      const auto [place, fresh] = nodeOf.add(v);
      if (fresh) {
        const Vector3 at = (domain.mesh.V.row(v).transpose() - centre) / reach;
        patch.nodes.push_back({at, v, at.squaredNorm() < 1.0, -1, 0.0});
      }
      n[static_cast<std::size_t>(k)] = place;
    }
    patch.tets.push_back(n);
    for (int k = 0; k < 4; ++k) {
      const std::int32_t next = domain.neighbours(queue[i], k);
      if (next < 0) {
        for (const int c : mesh::kTetFace[k]) {
          patch.nodes[static_cast<std::size_t>(n[static_cast<std::size_t>(c)])].free = false;
        }
        continue;
      }
      const bool within = std::ranges::any_of(mesh::kTetFace[k], [&](int c) {
        const auto node = static_cast<std::size_t>(n[static_cast<std::size_t>(c)]);
        return patch.nodes[node].at.squaredNorm() < 1.0;
      });
      if (within && seen.add(next).second) queue.push_back(next);
    }
  }
  for (Patch::Node& node : patch.nodes) {
    if (node.free) node.row = patch.rowCount++;
  }
  return patch;
}

// Barycentric coordinates in a tet as linear functions of place: λ(x) = at + slopes x. A sliver's
// volume is floored, as everywhere.
struct TetFrame {
  Eigen::Matrix<double, 4, 3> slopes;
  Eigen::Vector4d at;
  double V;

  TetFrame(const Patch& patch, std::size_t t) {
    std::array<Vector3, 4> p;
    for (std::size_t k = 0; k < 4; ++k)
      p[k] = patch.nodes[static_cast<std::size_t>(patch.tets[t][k])].at;
    const Vector3 e1 = p[1] - p[0];
    const Vector3 e2 = p[2] - p[0];
    const Vector3 e3 = p[3] - p[0];
    slopes.row(1) = e2.cross(e3).transpose() / 6.0;
    slopes.row(2) = e3.cross(e1).transpose() / 6.0;
    slopes.row(3) = e1.cross(e2).transpose() / 6.0;
    slopes.row(0) = -(slopes.row(1) + slopes.row(2) + slopes.row(3));
    V = std::max(e1.dot(slopes.row(1)), mesh::kFlattest);
    slopes *= 1.0 / V;
    for (int k = 0; k < 4; ++k)
      at[k] = -slopes.row(k).dot(p[static_cast<std::size_t>((k + 1) % 4)]);
  }
};

// Adds the part of a line of the given flux through x that lies inside the tet to the right-hand
// side
void addLine(const TetFrame& frame, const Vector3& x, const Vector3& tangent, double flux,
             const std::array<std::int32_t, 4>& rows, Eigen::VectorXd& b) {
  const Eigen::Vector4d at = frame.at + frame.slopes * x;
  const Eigen::Vector4d slope = frame.slopes * tangent;
  double s0 = -std::numeric_limits<double>::infinity();
  double s1 = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 4; ++k) {
    const double s = -at[k] / slope[k];
    if (slope[k] > 0.0) s0 = std::max(s0, s);
    if (slope[k] < 0.0) s1 = std::min(s1, s);
    if (slope[k] == 0.0 && at[k] < 0.0) return;
  }
  if (!(s1 > s0) || !std::isfinite(s1 - s0)) return;
  // Coordinates are linear along the piece: its middle stands for it
  const Eigen::Vector4d middle = at + 0.5 * (s0 + s1) * slope;
  for (std::size_t k = 0; k < 4; ++k) {
    if (rows[k] >= 0) b[rows[k]] += flux * (s1 - s0) * middle[static_cast<int>(k)];
  }
}

// Most patches have some fifty unknowns. Where large tets meet small ones they have thousands, and
// the dense factor would take minutes.
std::optional<Eigen::VectorXd> solve(const std::vector<Eigen::Triplet<double>>& lower,
                                     const Eigen::VectorXd& b) {
  constexpr Eigen::Index kDense = 150;
  if (b.size() <= kDense) {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(b.size(), b.size());
    for (const auto& entry : lower) K(entry.row(), entry.col()) += entry.value();
    const Eigen::LLT<Eigen::MatrixXd> factor(K);
    if (factor.info() != Eigen::Success) return std::nullopt;
    return factor.solve(b);
  }
  Eigen::SparseMatrix<double> K(b.size(), b.size());
  K.setFromTriplets(lower.begin(), lower.end());
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(K);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.solve(b);
}

double lineField(double r) { return -std::log(r) / (2.0 * std::numbers::pi); }

double awayFrom(const Vector3& line, const Vector3& tangent, const Vector3& p) {
  const Vector3 to = p - line;
  return (to - to.dot(tangent) * tangent).norm();
}

// A patch solved for lines of shared flux through the points, lengths in reaches
struct SolvedPatch {
  Patch patch;
  std::vector<std::int32_t> tetOfPoint;
  Vector3 centre;
  double reach = 1.0;
  double spread = 0.0;        // of the points about their centre [m]
  std::vector<Vector3> line;  // a point of each
  std::optional<Eigen::VectorXd> u;
};

SolvedPatch solveAround(const Domain& domain, std::span<const WellPoint> points,
                        const Vector3& tangent, double h) {
  EC_REQUIRE(!points.empty());
  SolvedPatch out;
  const double flux = 1.0 / static_cast<double>(points.size());
  out.centre = Vector3::Zero();
  for (const WellPoint& point : points) out.centre += flux * point.p;
  for (const WellPoint& point : points)
    out.spread = std::max(out.spread, (point.p - out.centre).norm());
  out.reach = std::max(kWellReach * h, out.spread + h);
  out.patch = gather(domain, points, out.centre, out.reach, out.tetOfPoint);
  Patch& patch = out.patch;

  // A line in a common face would count twice or not at all, so each is moved into the tet of its
  // point by a hair
  for (std::size_t i = 0; i < points.size(); ++i) {
    Vector3 middle = Vector3::Zero();
    for (const std::int32_t n : patch.tets[static_cast<std::size_t>(out.tetOfPoint[i])]) {
      middle += 0.25 * patch.nodes[static_cast<std::size_t>(n)].at;
    }
    const Vector3 x = (points[i].p - out.centre) / out.reach;
    out.line.push_back(x + 1e-6 * (middle - x));
  }
  // Exact field where it is prescribed; a vertex of the boundary may lie on a line itself
  for (Patch::Node& node : patch.nodes) {
    if (node.free) continue;
    for (const Vector3& x : out.line)
      node.line += flux * lineField(std::max(awayFrom(x, tangent, node.at), 0.1));
  }

  std::vector<Eigen::Triplet<double>> K;
  Eigen::VectorXd b = Eigen::VectorXd::Zero(patch.rowCount);
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    const TetFrame frame(patch, t);
    std::array<const Patch::Node*, 4> node{};
    std::array<std::int32_t, 4> rows{};
    for (std::size_t k = 0; k < 4; ++k) {
      node[k] = &patch.nodes[static_cast<std::size_t>(patch.tets[t][k])];
      rows[k] = node[k]->row;
    }
    for (std::size_t i = 0; i < 4; ++i) {
      if (rows[i] < 0) continue;
      for (std::size_t j = 0; j < 4; ++j) {
        if (rows[j] > rows[i]) continue;  // the lower triangle is enough
        const double k =
            frame.V *
            frame.slopes.row(static_cast<int>(i)).dot(frame.slopes.row(static_cast<int>(j)));
        if (rows[j] >= 0) {
          K.emplace_back(rows[i], rows[j], k);
        } else {
          b[rows[i]] -= k * node[j]->line;
        }
      }
    }
    for (const Vector3& x : out.line) addLine(frame, x, tangent, flux, rows, b);
  }

  out.u = solve(K, b);
  return out;
}

double radiusOf(const SolvedPatch& solved, std::span<const WellPoint> points, double h) {
  const double guess = kWellC * h;
  if (!solved.u) return guess;
  const Patch& patch = solved.patch;
  double reads = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto t = static_cast<std::size_t>(solved.tetOfPoint[i]);
    const TetFrame frame(patch, t);
    const Eigen::Vector4d own =
        frame.at + frame.slopes * ((points[i].p - solved.centre) / solved.reach);
    for (std::size_t k = 0; k < 4; ++k) {
      const Patch::Node& node = patch.nodes[static_cast<std::size_t>(patch.tets[t][k])];
      reads += own[static_cast<int>(k)] * (node.row >= 0 ? (*solved.u)[node.row] : node.line);
    }
  }
  reads /= static_cast<double>(points.size());
  const double radius = solved.reach * std::exp(-2.0 * std::numbers::pi * reads);
  if (!std::isfinite(radius)) return std::max(guess, solved.spread);
  return std::clamp(radius, std::max(kLeastWell * guess, 0.9 * solved.spread),
                    guess / kLeastWell + solved.spread);
}

}  // namespace

Well wellAround(const Domain& domain, const WellPoint& point, const Vector3& tangent, double h,
                double coreRadius) {
  const std::span<const WellPoint> points(&point, 1);
  const SolvedPatch solved = solveAround(domain, points, tangent, h);
  Well out{radiusOf(solved, points, h), {}};
  if (!solved.u || !solved.u->allFinite()) return out;
  const double nearest = std::max(coreRadius, kNearLine * h) / solved.reach;
  for (const Patch::Node& node : solved.patch.nodes) {
    if (node.row < 0) continue;
    const double r = std::max(awayFrom(solved.line[0], tangent, node.at), nearest);
    out.errors.push_back({node.vertex, (*solved.u)[node.row] - lineField(r)});
  }
  return out;
}

double wellRadius(const Domain& domain, std::span<const WellPoint> points, const Vector3& tangent,
                  double h) {
  return radiusOf(solveAround(domain, points, tangent, h), points, h);
}

double wellRadius(const Domain& domain, std::int32_t tet, const Vector3& p, const Vector3& tangent,
                  double h) {
  const WellPoint point{p, tet};
  return wellRadius(domain, std::span(&point, 1), tangent, h);
}

}  // namespace ecorche::tissue
