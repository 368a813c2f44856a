#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
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
#include <mutex>
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
  Arrivals() : table_(1024, {-1, -1}) {}

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

// The domain's stiffness, vertex by vertex: neighbours and what couples to them [m]
struct Coupling {
  mesh::VertexTets tetsOf;
  mesh::NeighbourRows rows;            // of all vertices
  std::vector<double> k;               // of each neighbour
  std::vector<double> own;             // #V
  std::vector<std::uint8_t> boundary;  // #V
  struct Ball {
    Eigen::Vector3f centre;
    float radius;
  };
  std::vector<Ball> around;  // each tet, with some room [m]

  explicit Coupling(const Domain& domain) {
    const auto n = static_cast<std::size_t>(domain.mesh.V.rows());
    mesh::StiffnessPattern pattern =
        mesh::stiffnessPattern(domain.mesh, std::vector<std::uint8_t>(n, 0));
    const std::vector<double> lower =
        mesh::assembleStiffness(domain.mesh, pattern, mesh::edgeStiffness(domain.mesh));
    tetsOf = std::move(pattern.vertexTets);
    for (std::size_t v = 0; v < n; ++v)
      own.push_back(lower[static_cast<std::size_t>(pattern.first[v])]);
    rows = mesh::neighbourRows(pattern);
    k.reserve(rows.slot.size());
    for (const std::int32_t slot : rows.slot) k.push_back(lower[static_cast<std::size_t>(slot)]);
    around.resize(static_cast<std::size_t>(domain.mesh.T.rows()));
    parallelFor(domain.mesh.T.rows(), [&](std::int64_t t) {
      const auto corners = domain.mesh.V(domain.mesh.T.row(t), Eigen::all);
      const Eigen::RowVector3d centre = corners.colwise().mean();
      const double radius = (corners.rowwise() - centre).rowwise().norm().maxCoeff();
      // Coordinates are rounded to 32 bits
      around[static_cast<std::size_t>(t)] = {
          centre.transpose().cast<float>(),
          static_cast<float>(1.001 * radius + 1e-6 * centre.cwiseAbs().maxCoeff())};
    });
    boundary.assign(n, 0);
    for (const std::int32_t v : domain.boundaryF.reshaped())
      boundary[static_cast<std::size_t>(v)] = 1;
  }
};

// Vertices around a row, lengths in reaches from the centre, so that units cancel.
struct Patch {
  struct Node {
    Vector3 at;
    std::int32_t vertex;
    std::int32_t row = -1;  // within reach and not on the boundary: unknown
    double line = 0.0;      // the line's field, where it is prescribed and some row asks for it
    bool lineKnown = false;
  };
  Vector3 centre;
  double reach = 1.0;
  std::vector<Node> nodes;
  std::vector<std::int32_t> free;  // node of each row
  // Nodes beside each row, in the order of Coupling
  std::vector<std::int32_t> first{0};
  std::vector<std::int32_t> beside;
  Arrivals nodeOf;

  std::int32_t add(const Domain& domain, std::int32_t v) {
    const auto [place, fresh] = nodeOf.add(v);
    if (fresh) nodes.push_back({(domain.mesh.V.row(v).transpose() - centre) / reach, v});
    return place;
  }
  [[nodiscard]] Eigen::Index rowCount() const { return std::ssize(free); }
};

Patch gather(const Domain& domain, const Coupling& coupling, std::span<const WellPoint> points,
             const Vector3& centre, double reach) {
  Patch patch;
  patch.centre = centre;
  patch.reach = reach;
  patch.nodes.reserve(256);
  for (const WellPoint& point : points) {
    for (int k = 0; k < 4; ++k) (void)patch.add(domain, domain.mesh.T(point.tet, k));
  }
  for (std::size_t i = 0; i < patch.nodes.size(); ++i) {
    const auto v = static_cast<std::size_t>(patch.nodes[i].vertex);
    if (!(patch.nodes[i].at.squaredNorm() < 1.0)) continue;
    const bool unknown = coupling.boundary[v] == 0;
    for (auto e = coupling.rows.first[v]; e < coupling.rows.first[v + 1]; ++e) {
      const std::int32_t n =
          patch.add(domain, coupling.rows.neighbour[static_cast<std::size_t>(e)]);
      if (unknown) patch.beside.push_back(n);
    }
    if (!unknown) continue;
    patch.nodes[i].row = static_cast<std::int32_t>(patch.free.size());
    patch.free.push_back(static_cast<std::int32_t>(i));
    patch.first.push_back(static_cast<std::int32_t>(patch.beside.size()));
  }
  return patch;
}

// Barycentric coordinates in a tet as linear functions of place: λ(x) = at + slopes x. A sliver's
// volume is floored, as everywhere.
struct TetFrame {
  Eigen::Matrix<double, 4, 3> slopes;
  Eigen::Vector4d at;

  explicit TetFrame(const std::array<Vector3, 4>& p) {
    const Vector3 e1 = p[1] - p[0];
    const Vector3 e2 = p[2] - p[0];
    const Vector3 e3 = p[3] - p[0];
    slopes.row(1) = e2.cross(e3).transpose() / 6.0;
    slopes.row(2) = e3.cross(e1).transpose() / 6.0;
    slopes.row(3) = e1.cross(e2).transpose() / 6.0;
    slopes.row(0) = -(slopes.row(1) + slopes.row(2) + slopes.row(3));
    slopes *= 1.0 / std::max(e1.dot(slopes.row(1)), mesh::kFlattest);
    for (int k = 0; k < 4; ++k)
      at[k] = -slopes.row(k).dot(p[static_cast<std::size_t>((k + 1) % 4)]);
  }
};

double lineField(double r) { return -std::log(r) / (2.0 * std::numbers::pi); }

// Lines of one direction, each with the same flux, close to one that runs through the centre.
struct Lines {
  using Across = Eigen::Vector2d;

  Vector3 tangent;
  Eigen::Matrix<double, 2, 3> across;  // onto the plane that they pierce
  std::vector<Vector3> through;
  std::vector<Across> at;  // in that plane
  double flux = 1.0;       // of each
  double spread = 0.0;     // how far they are from the centre at most

  Lines(const Vector3& theTangent, std::size_t count)
      : tangent(theTangent), flux(1.0 / static_cast<double>(count)) {
    const Vector3 one = tangent.unitOrthogonal();
    across.row(0) = one.transpose();
    across.row(1) = tangent.cross(one).transpose();
  }
  void add(const Vector3& x) {
    through.push_back(x);
    at.emplace_back(across * x);
    spread = std::max(spread, at.back().norm());
  }
  // The lines' field. A vertex of the boundary may lie on a line itself. At most two dozen lines,
  // none far off: the product of their distances needs one logarithm
  [[nodiscard]] double fieldAt(const Vector3& p) const {
    const Across here = across * p;
    double product = 1.0;
    for (const Across& line : at) product *= std::max((here - line).squaredNorm(), 0.01);
    return 0.5 * flux * lineField(product);
  }
};

// Adds those parts of lines that lie inside a tet to the right-hand side.
void addLines(const Domain& domain, const Coupling& coupling, std::int32_t tet, const Lines& lines,
              Patch& patch, Eigen::VectorXd& b) {
  const Coupling::Ball& ball = coupling.around[static_cast<std::size_t>(tet)];
  const Lines::Across here =
      lines.across * ((ball.centre.cast<double>() - patch.centre) * (1.0 / patch.reach));
  const double radius = static_cast<double>(ball.radius) / patch.reach;
  const double most = lines.spread + radius;
  if (here.squaredNorm() > most * most) return;
  std::optional<TetFrame> frame;
  std::array<std::int32_t, 4> rows{};
  Eigen::Vector4d slope;
  Eigen::Vector4d run;
  for (std::size_t i = 0; i < lines.at.size(); ++i) {
    if ((here - lines.at[i]).squaredNorm() > radius * radius) continue;
    if (!frame) {
      std::array<Vector3, 4> corner;
      for (int k = 0; k < 4; ++k) {
        const Patch::Node& node =
            patch.nodes[static_cast<std::size_t>(patch.add(domain, domain.mesh.T(tet, k)))];
        corner[static_cast<std::size_t>(k)] = node.at;
        rows[static_cast<std::size_t>(k)] = node.row;
      }
      frame.emplace(corner);
      slope = frame->slopes * lines.tangent;
      run = slope.cwiseInverse();
    }
    const Eigen::Vector4d at = frame->at + frame->slopes * lines.through[i];
    double s0 = -std::numeric_limits<double>::infinity();
    double s1 = std::numeric_limits<double>::infinity();
    bool beside = false;
    for (int k = 0; k < 4; ++k) {
      const double s = -at[k] * run[k];
      if (slope[k] > 0.0) s0 = std::max(s0, s);
      if (slope[k] < 0.0) s1 = std::min(s1, s);
      beside = beside || (slope[k] == 0.0 && at[k] < 0.0);
    }
    if (beside || !(s1 > s0) || !std::isfinite(s1 - s0)) continue;
    // Coordinates are linear along the piece: its middle stands for it
    const Eigen::Vector4d middle = at + 0.5 * (s0 + s1) * slope;
    for (std::size_t k = 0; k < 4; ++k) {
      if (rows[k] >= 0) b[rows[k]] += lines.flux * (s1 - s0) * middle[static_cast<int>(k)];
    }
  }
}

std::optional<Eigen::VectorXd> solve(const Eigen::MatrixXd& lower, const Eigen::VectorXd& b) {
  const Eigen::LLT<Eigen::MatrixXd> factor(lower);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.solve(b);
}
std::optional<Eigen::VectorXd> solve(const std::vector<Eigen::Triplet<double>>& lower,
                                     const Eigen::VectorXd& b) {
  Eigen::SparseMatrix<double> K(b.size(), b.size());
  K.setFromTriplets(lower.begin(), lower.end());
  const Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor(K);
  if (factor.info() != Eigen::Success) return std::nullopt;
  return factor.solve(b);
}

// A patch solved for lines of shared flux through the points
struct SolvedPatch {
  Patch patch;
  double spread = 0.0;  // of the points about their centre [m]
  Lines lines;
  std::optional<Eigen::VectorXd> u;

  SolvedPatch(const Vector3& tangent, std::size_t count) : lines(tangent, count) {}

  [[nodiscard]] std::array<Vector3, 4> corners(const Domain& domain, std::int32_t tet) const {
    std::array<Vector3, 4> p;
    for (int k = 0; k < 4; ++k)
      p[static_cast<std::size_t>(k)] =
          (domain.mesh.V.row(domain.mesh.T(tet, k)).transpose() - patch.centre) / patch.reach;
    return p;
  }
};

SolvedPatch solveAround(const Domain& domain, const Coupling& coupling,
                        std::span<const WellPoint> points, const Vector3& tangent, double h) {
  EC_REQUIRE(!points.empty());
  SolvedPatch out(tangent, points.size());
  Vector3 centre = Vector3::Zero();
  for (const WellPoint& point : points)
    centre += 1.0 / static_cast<double>(points.size()) * point.p;
  for (const WellPoint& point : points)
    out.spread = std::max(out.spread, (point.p - centre).norm());
  const double reach = std::max(kWellReach * h, out.spread + h);
  out.patch = gather(domain, coupling, points, centre, reach);
  Patch& patch = out.patch;

  // A line in a common face would count twice or not at all, so each is moved into the tet of its
  // point by a hair
  for (const WellPoint& point : points) {
    const std::array<Vector3, 4> p = out.corners(domain, point.tet);
    const Vector3 x = (point.p - centre) / reach;
    out.lines.add(x + 1e-6 * (0.25 * (p[0] + p[1] + p[2] + p[3]) - x));
  }

  // Most patches have some fifty unknowns. Where large tets meet small ones they have thousands,
  // and the dense factor would take minutes
  constexpr Eigen::Index kDense = 150;
  const Eigen::Index n = patch.rowCount();
  const bool dense = n <= kDense;
  Eigen::MatrixXd D;
  std::vector<Eigen::Triplet<double>> S;
  if (dense) D = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(n);
  Arrivals seen;
  for (std::int32_t r = 0; r < n; ++r) {
    const auto at = static_cast<std::size_t>(r);
    const auto v =
        static_cast<std::size_t>(patch.nodes[static_cast<std::size_t>(patch.free[at])].vertex);
    const auto enter = [&](std::int32_t c, double k) {
      if (dense) {
        D(r, c) = k;
      } else {
        S.emplace_back(r, c, k);
      }
    };
    // K in units of the reach
    enter(r, coupling.own[v] / reach);
    const std::int32_t* e = coupling.rows.first.data() + v;
    for (std::int32_t i = 0; i < e[1] - e[0]; ++i) {
      Patch::Node& other = patch.nodes[static_cast<std::size_t>(
          patch.beside[static_cast<std::size_t>(patch.first[at] + i)])];
      const double k = coupling.k[static_cast<std::size_t>(e[0] + i)] / reach;
      if (other.row >= 0) {
        if (other.row < r) enter(other.row, k);  // the lower triangle is enough
        continue;
      }
      if (!other.lineKnown) {
        other.line = out.lines.fieldAt(other.at);
        other.lineKnown = true;
      }
      b[r] -= k * other.line;
    }
    for (auto i = coupling.tetsOf.first[v]; i < coupling.tetsOf.first[v + 1]; ++i) {
      const std::int32_t tet = coupling.tetsOf.tet[static_cast<std::size_t>(i)];
      if (seen.add(tet).second) addLines(domain, coupling, tet, out.lines, patch, b);
    }
  }
  out.u = dense ? solve(D, b) : solve(S, b);
  return out;
}

double radiusOf(const Domain& domain, SolvedPatch& solved, std::span<const WellPoint> points,
                double h) {
  const double guess = kWellC * h;
  if (!solved.u) return guess;
  Patch& patch = solved.patch;
  double reads = 0.0;
  for (const WellPoint& point : points) {
    const TetFrame frame(solved.corners(domain, point.tet));
    const Eigen::Vector4d own = frame.at + frame.slopes * ((point.p - patch.centre) / patch.reach);
    for (int k = 0; k < 4; ++k) {
      const Patch::Node& node =
          patch.nodes[static_cast<std::size_t>(patch.add(domain, domain.mesh.T(point.tet, k)))];
      reads += own[k] * (node.row >= 0 ? (*solved.u)[node.row] : solved.lines.fieldAt(node.at));
    }
  }
  reads /= static_cast<double>(points.size());
  const double radius = patch.reach * std::exp(-2.0 * std::numbers::pi * reads);
  if (!std::isfinite(radius)) return std::max(guess, solved.spread);
  return std::clamp(radius, std::max(kLeastWell * guess, 0.9 * solved.spread),
                    guess / kLeastWell + solved.spread);
}

}  // namespace

struct WellSolver::Impl {
  const Domain& domain;
  std::once_flag once;
  std::optional<Coupling> made;

  explicit Impl(const Domain& d) : domain(d) {}
  const Coupling& coupling() {
    std::call_once(once, [this] { made.emplace(domain); });
    return *made;
  }
};

WellSolver::WellSolver(const Domain& domain) : impl_(std::make_unique<Impl>(domain)) {}
WellSolver::~WellSolver() = default;
WellSolver::WellSolver(WellSolver&&) noexcept = default;
WellSolver& WellSolver::operator=(WellSolver&&) noexcept = default;

Well WellSolver::around(const WellPoint& point, const Vector3& tangent, double h,
                        double coreRadius) const {
  const std::span<const WellPoint> points(&point, 1);
  SolvedPatch solved = solveAround(impl_->domain, impl_->coupling(), points, tangent, h);
  Well out{radiusOf(impl_->domain, solved, points, h), {}};
  if (!solved.u || !solved.u->allFinite()) return out;
  const double nearest = std::max(coreRadius, kNearLine * h) / solved.patch.reach;
  for (std::size_t r = 0; r < solved.patch.free.size(); ++r) {
    const Patch::Node& node = solved.patch.nodes[static_cast<std::size_t>(solved.patch.free[r])];
    const double away2 = (solved.lines.across * node.at - solved.lines.at.front()).squaredNorm();
    out.errors.push_back(
        {node.vertex, (*solved.u)[static_cast<Eigen::Index>(r)] -
                          lineField(std::sqrt(std::max(away2, nearest * nearest)))});
  }
  return out;
}

double WellSolver::radius(std::span<const WellPoint> points, const Vector3& tangent,
                          double h) const {
  SolvedPatch solved = solveAround(impl_->domain, impl_->coupling(), points, tangent, h);
  return radiusOf(impl_->domain, solved, points, h);
}

}  // namespace ecorche::tissue
