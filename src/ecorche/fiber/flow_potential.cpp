#include <ecorche/core/contract.h>
#include <ecorche/fiber/flow_potential.h>
#include <ecorche/mesh/cholesky.h>
#include <ecorche/mesh/operators.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace ecorche::fiber {

using mesh::Vector3;

namespace {

// A finite element problem: nodes, tets between them with the volume that counts, and what flows in
// and out.
struct Problem {
  mesh::TetMesh mesh;                   // of elements
  std::vector<double> volume;           // that the muscle has in each element
  std::vector<Eigen::Matrix3d> tensor;  // mean over that volume
  std::vector<double> inflow;           // per node, not negative
  std::vector<double> outflow;          // per node, not negative
};

// I + γ φ (I − t tᵀ): moving potential across the tube is cheap to equalise, so the gradient turns
// along it.
Eigen::Matrix3d tensorAt(const CurveGuide::Nearest& n, const CurveGuide& guide,
                         const FiberOptions& options) {
  const double radius = options.tubeRadiusRel * guide.radius(n.curve, n.arc);
  const double phi = std::exp(-(n.distance * n.distance) / (radius * radius));
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  return I + options.curveWeight * phi * (I - n.tangent * n.tangent.transpose());
}

// The piece of connected elements that each node belongs to, pieces numbered by their first node.
std::vector<std::int32_t> pieceOfNode(const mesh::TetMesh& elements) {
  std::vector<std::int32_t> parent(static_cast<std::size_t>(elements.V.rows()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](std::int32_t v) {
    while (parent[static_cast<std::size_t>(v)] != v) {
      parent[static_cast<std::size_t>(v)] =
          parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(v)])];
      v = parent[static_cast<std::size_t>(v)];
    }
    return v;
  };
  for (Eigen::Index t = 0; t < elements.T.rows(); ++t) {
    for (int k = 1; k < 4; ++k) {
      const std::int32_t a = find(elements.T(t, 0));
      const std::int32_t b = find(elements.T(t, k));
      parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
  // Roots are the least of their piece: they come first
  std::vector<std::int32_t> piece(parent.size());
  std::int32_t count = 0;
  for (std::size_t v = 0; v < parent.size(); ++v) {
    const std::int32_t root = find(static_cast<std::int32_t>(v));
    piece[v] =
        root == static_cast<std::int32_t>(v) ? count++ : piece[static_cast<std::size_t>(root)];
  }
  return piece;
}

// Minimises ½ Σ V ∇uᵀ A ∇u − Σ (inflow − outflow) u, what leaves a piece made as much as what
// enters. The level of every piece is free: inflow's mean of u is 0, outflow's 1.
Result<Eigen::VectorXd> solve(const Problem& p, const std::string& name) {
  const auto nodeCount = p.inflow.size();
  if (nodeCount == 0) return Eigen::VectorXd();  // nothing but unended pieces
  const std::vector<std::int32_t> piece = pieceOfNode(p.mesh);
  const auto pieceCount = static_cast<std::size_t>(*std::ranges::max_element(piece)) + 1;
  std::vector<double> in(pieceCount, 0.0);
  std::vector<double> out(pieceCount, 0.0);
  std::vector<std::uint8_t> fixed(nodeCount, 0);  // the first node of every piece
  for (std::size_t v = 0, next = 0; v < nodeCount; ++v) {
    const auto i = static_cast<std::size_t>(piece[v]);
    if (i == next) fixed[v] = ++next > 0;
    in[i] += p.inflow[v];
    out[i] += p.outflow[v];
  }
  for (std::size_t i = 0; i < pieceCount; ++i) EC_REQUIRE(in[i] > 0.0 && out[i] > 0.0);
  const mesh::StiffnessPattern pattern = mesh::stiffnessPattern(p.mesh, fixed);

  // Each element counts with the share of it that is muscle
  mesh::EdgeStiffness K = mesh::edgeStiffness(p.mesh, p.tensor);
  for (Eigen::Index t = 0; t < p.mesh.T.rows(); ++t) {
    const double share = p.volume[static_cast<std::size_t>(t)] / mesh::signedVolume(p.mesh, t);
    for (double& k : K.k[static_cast<std::size_t>(t)]) k *= share;
  }
  Eigen::MatrixXd x(pattern.rowCount(), 1);
  for (std::int32_t r = 0; r < pattern.rowCount(); ++r) {
    const auto v = static_cast<std::size_t>(pattern.vertex[static_cast<std::size_t>(r)]);
    const auto i = static_cast<std::size_t>(piece[v]);
    // u grows from origin to insertion: the flow goes up, not down
    x(r, 0) = p.outflow[v] * (in[i] / out[i]) - p.inflow[v];
  }

  // Muscles are solved beside one another: each with one thread, in an order that does not depend
  // on the others
  const mesh::SymbolicCholesky symbolic(pattern, mesh::Ordering::MinimumDegree);
  const mesh::Cholesky factor(symbolic, mesh::assembleStiffness(p.mesh, pattern, K), 1);
  if (factor.ok()) factor.solveInPlace(x);
  if (!factor.ok() || !x.allFinite()) {
    return fail(
        ErrorCode::SystemSingular,
        fmt::format("the flow through \"{}\" has no unique solution; its tets are degenerate: "
                    "change the resolution",
                    name),
        {.object = name});
  }
  Eigen::VectorXd u = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(nodeCount));
  for (std::int32_t r = 0; r < pattern.rowCount(); ++r)
    u[pattern.vertex[static_cast<std::size_t>(r)]] = x(r, 0);

  std::vector<double> first(pieceCount, 0.0);
  std::vector<double> last(pieceCount, 0.0);
  for (std::size_t v = 0; v < nodeCount; ++v) {
    const auto i = static_cast<std::size_t>(piece[v]);
    first[i] += p.inflow[v] / in[i] * u[static_cast<Eigen::Index>(v)];
    last[i] += p.outflow[v] / out[i] * u[static_cast<Eigen::Index>(v)];
  }
  for (std::size_t v = 0; v < nodeCount; ++v) {
    const auto i = static_cast<std::size_t>(piece[v]);
    double& value = u[static_cast<Eigen::Index>(v)];
    // The difference is the flow's energy over what flows: positive, unless all of it leaves where
    // it enters
    const double rise = last[i] - first[i];
    value = (value - first[i]) / (rise > 0.0 ? rise : 1.0);
  }
  return u;
}

// Unended pieces carry no flow.
bool flows(const MuscleMesh& muscle, const SelectedEnds& ends, Eigen::Index t) {
  return !ends.unended[static_cast<std::size_t>(muscle.component[static_cast<std::size_t>(t)])];
}

// Tets and vertices of the domain with both numberings, and which element every tet of the muscle
// lies in.
struct Discretised {
  Problem problem;
  std::vector<std::int32_t> nodeId;   // node → domain vertex, ascending
  std::vector<std::int32_t> element;  // per muscle tet, -1 in unended pieces

  [[nodiscard]] std::int32_t node(std::int32_t id) const {
    const auto at = std::ranges::lower_bound(nodeId, id);
    return at != nodeId.end() && *at == id ? static_cast<std::int32_t>(at - nodeId.begin()) : -1;
  }
};

Discretised discretise(const MuscleMesh& muscle, const envelope::Anatomy& anatomy,
                       const domain::Domain& domain, const SelectedEnds& ends,
                       const CurveGuide& guide,
                       const std::vector<CurveGuide::Nearest>& nearestOfTet,
                       const FiberOptions& options) {
  const mesh::TetMesh& whole = domain.mesh;
  std::vector<std::int32_t> elementId(muscle.tetId.size());
  for (std::size_t t = 0; t < elementId.size(); ++t) {
    elementId[t] = anatomy.parentTet[static_cast<std::size_t>(muscle.tetId[t])];
  }
  // Elements that hold some of the muscle, each once
  std::vector<std::int32_t> used;
  for (std::size_t t = 0; t < elementId.size(); ++t) {
    if (flows(muscle, ends, static_cast<Eigen::Index>(t))) used.push_back(elementId[t]);
  }
  std::ranges::sort(used);
  used.erase(std::ranges::unique(used).begin(), used.end());

  Discretised d;
  for (const std::int32_t e : used) {
    for (int k = 0; k < 4; ++k) d.nodeId.push_back(whole.T(e, k));
  }
  std::ranges::sort(d.nodeId);
  d.nodeId.erase(std::ranges::unique(d.nodeId).begin(), d.nodeId.end());

  Problem& p = d.problem;
  p.mesh.V.resize(static_cast<Eigen::Index>(d.nodeId.size()), 3);
  for (std::size_t v = 0; v < d.nodeId.size(); ++v) {
    p.mesh.V.row(static_cast<Eigen::Index>(v)) = whole.V.row(d.nodeId[v]);
  }
  p.mesh.T.resize(static_cast<Eigen::Index>(used.size()), 4);
  for (std::size_t e = 0; e < used.size(); ++e) {
    for (int k = 0; k < 4; ++k)
      p.mesh.T(static_cast<Eigen::Index>(e), k) = d.node(whole.T(used[e], k));
  }

  // Volumes and tensors of the muscle's tets add up in their element
  p.volume.assign(used.size(), 0.0);
  p.tensor.assign(used.size(), Eigen::Matrix3d::Zero());
  d.element.assign(elementId.size(), -1);
  for (std::size_t t = 0; t < elementId.size(); ++t) {
    if (!flows(muscle, ends, static_cast<Eigen::Index>(t))) continue;
    const auto e =
        static_cast<std::size_t>(std::ranges::lower_bound(used, elementId[t]) - used.begin());
    d.element[t] = static_cast<std::int32_t>(e);
    const double v = std::max(0.0, muscle.volume[static_cast<Eigen::Index>(t)]);
    p.volume[e] += v;
    p.tensor[e] += v * tensorAt(nearestOfTet[t], guide, options);
  }
  for (std::size_t e = 0; e < used.size(); ++e) {
    if (p.volume[e] > 0.0) {
      p.tensor[e] /= p.volume[e];
    } else {
      p.tensor[e].setIdentity();
    }
    // An element that the muscle only touches still has to hold its nodes
    const double least = 1e-12 * mesh::signedVolume(p.mesh, static_cast<Eigen::Index>(e));
    p.volume[e] = std::max(p.volume[e], least);
  }
  p.inflow.assign(d.nodeId.size(), 0.0);
  p.outflow.assign(d.nodeId.size(), 0.0);
  return d;
}

// A vertex of the muscle as a mean of nodes.
struct NodeWeights {
  std::array<std::int32_t, 4> node{-1, -1, -1, -1};
  std::array<double, 4> weight{0.0, 0.0, 0.0, 0.0};
};

// Through every face of an end flows its share by area, a third at each corner.
void applyEnds(Problem& p, const MuscleMesh& muscle, const SelectedEnds& ends,
               const std::vector<NodeWeights>& nodes) {
  for (const FlowEnd& end : ends.flow) {
    std::vector<double>& into = end.role == Role::Origin ? p.inflow : p.outflow;
    for (const std::int32_t f : end.faces) {
      const auto& v = muscle.surface[static_cast<std::size_t>(f)].v;
      const Vector3 a = muscle.mesh.V.row(v[0]).transpose();
      const double area = 0.5 * (muscle.mesh.V.row(v[1]).transpose() - a)
                                    .cross(muscle.mesh.V.row(v[2]).transpose() - a)
                                    .norm();
      for (const std::int32_t corner : v) {
        const NodeWeights& n = nodes[static_cast<std::size_t>(corner)];
        for (std::size_t k = 0; k < 4; ++k) {
          if (n.node[k] < 0) continue;
          into[static_cast<std::size_t>(n.node[k])] +=
              n.weight[k] * end.flux * area / end.area / 3.0;
        }
      }
    }
  }
}

FlowPotential spreadToTets(const Discretised& d, const Eigen::VectorXd& nodeU,
                           const std::vector<NodeWeights>& nodes) {
  FlowPotential flow;
  flow.u = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t v = 0; v < nodes.size(); ++v) {
    for (std::size_t k = 0; k < 4; ++k) {
      if (nodes[v].node[k] < 0) continue;
      flow.u[static_cast<Eigen::Index>(v)] += nodes[v].weight[k] * nodeU[nodes[v].node[k]];
    }
  }
  std::vector<Vector3> gradient(static_cast<std::size_t>(d.problem.mesh.T.rows()));
  for (Eigen::Index e = 0; e < d.problem.mesh.T.rows(); ++e) {
    Eigen::Vector4d corners;
    for (int k = 0; k < 4; ++k) corners[k] = nodeU[d.problem.mesh.T(e, k)];
    // Differences to the mean: a gradient knows nothing of the level, and rounding should not
    // either
    corners.array() -= corners.mean();
    gradient[static_cast<std::size_t>(e)] =
        mesh::barycentricGradients(d.problem.mesh, e).transpose() * corners;
  }
  flow.gradient.setZero(static_cast<Eigen::Index>(d.element.size()), 3);
  for (std::size_t t = 0; t < d.element.size(); ++t) {
    if (d.element[t] < 0) continue;
    flow.gradient.row(static_cast<Eigen::Index>(t)) =
        gradient[static_cast<std::size_t>(d.element[t])].transpose();
  }
  return flow;
}

// New vertices lie on the domain's tets, where u is linear.
std::vector<NodeWeights> nodesOfVertices(const Discretised& d, const MuscleMesh& muscle,
                                         const envelope::Anatomy& anatomy,
                                         std::int32_t domainVertexCount) {
  std::vector<NodeWeights> out(muscle.vertexId.size());
  for (std::size_t v = 0; v < out.size(); ++v) {
    const std::int32_t id = muscle.vertexId[v];
    if (id < domainVertexCount) {
      out[v] = {{d.node(id), -1, -1, -1}, {1.0, 0.0, 0.0, 0.0}};
      continue;
    }
    const auto& origin = anatomy.origin[static_cast<std::size_t>(id - domainVertexCount)];
    for (std::size_t k = 0; k < 4; ++k) {
      if (origin.corner[k] >= 0) out[v].node[k] = d.node(origin.corner[k]);
      out[v].weight[k] = origin.weight[k];
    }
  }
  return out;
}

}  // namespace

Result<FlowPotential> solveFlow(const MuscleMesh& muscle, const envelope::Anatomy& anatomy,
                                const domain::Domain& domain, const SelectedEnds& ends,
                                const CurveGuide& guide,
                                const std::vector<CurveGuide::Nearest>& nearestOfTet,
                                const FiberOptions& options, const std::string& name) {
  EC_REQUIRE_EQ(nearestOfTet.size(), muscle.tetId.size());
  Discretised d = discretise(muscle, anatomy, domain, ends, guide, nearestOfTet, options);
  const std::vector<NodeWeights> nodes =
      nodesOfVertices(d, muscle, anatomy, static_cast<std::int32_t>(domain.mesh.V.rows()));
  applyEnds(d.problem, muscle, ends, nodes);
  auto nodeU = solve(d.problem, name);
  if (!nodeU) return passOn(nodeU);
  return spreadToTets(d, *nodeU, nodes);
}

Eigen::VectorXd progressAlongHeads(const MuscleMesh& muscle, const SelectedEnds& ends,
                                   const CurveGuide& guide, const Eigen::VectorXd& u) {
  if (guide.curveCount() == 1) return u;
  // u at the ends of every head, mean by area
  std::vector<double> level;
  for (const FlowEnd& end : ends.flow) {
    double sum = 0.0;
    for (const std::int32_t f : end.faces) {
      const auto& v = muscle.surface[static_cast<std::size_t>(f)].v;
      const Vector3 a = muscle.mesh.V.row(v[0]).transpose();
      const double area = 0.5 * (muscle.mesh.V.row(v[1]).transpose() - a)
                                    .cross(muscle.mesh.V.row(v[2]).transpose() - a)
                                    .norm();
      sum += area / 3.0 * (u[v[0]] + u[v[1]] + u[v[2]]);
    }
    level.push_back(end.area > 0.0 ? sum / end.area : end.role == Role::Origin ? 0.0 : 1.0);
  }
  Eigen::VectorXd out(u.size());
  for (Eigen::Index v = 0; v < u.size(); ++v) {
    const Vector3 x = muscle.mesh.V.row(v).transpose();
    double first = 0.0;
    double last = 0.0;
    double total = 0.0;
    for (std::int32_t c = 0; c < guide.curveCount(); ++c) {
      const double far = guide.distance(c, x) / guide.length(c);
      const double weight = 1.0 / (far * far + 1e-12);
      first += weight * level[2 * static_cast<std::size_t>(c)];
      last += weight * level[2 * static_cast<std::size_t>(c) + 1];
      total += weight;
    }
    // A head that goes nowhere takes the muscle's own measure
    const double gain = (last - first) / total;
    out[v] = gain > 0.1 ? (u[v] - first / total) / gain : u[v];
  }
  return out;
}

}  // namespace ecorche::fiber
