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

// A finite element problem: nodes, tets between them with the volume that counts, and what is held.
struct Problem {
  mesh::TetMesh mesh;                   // of elements
  std::vector<double> volume;           // that the muscle has in each element
  std::vector<Eigen::Matrix3d> tensor;  // mean over that volume
  std::vector<Role> held;               // per node
  std::vector<double> value;            // per node, where it is held
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

// Elements without both ends would make the system singular: every connected group of elements must
// hold both.
bool everyGroupHeld(const Problem& p) {
  std::vector<std::int32_t> parent(static_cast<std::size_t>(p.mesh.V.rows()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto find = [&](std::int32_t v) {
    while (parent[static_cast<std::size_t>(v)] != v) {
      parent[static_cast<std::size_t>(v)] =
          parent[static_cast<std::size_t>(parent[static_cast<std::size_t>(v)])];
      v = parent[static_cast<std::size_t>(v)];
    }
    return v;
  };
  for (Eigen::Index t = 0; t < p.mesh.T.rows(); ++t) {
    for (int k = 1; k < 4; ++k)
      parent[static_cast<std::size_t>(find(p.mesh.T(t, k)))] = find(p.mesh.T(t, 0));
  }
  std::vector<std::array<bool, 2>> has(parent.size(), {false, false});
  for (std::size_t v = 0; v < parent.size(); ++v) {
    if (p.held[v] == Role::None) continue;
    has[static_cast<std::size_t>(find(static_cast<std::int32_t>(v)))]
       [p.held[v] == Role::Insertion ? 1 : 0] = true;
  }
  for (std::size_t v = 0; v < parent.size(); ++v) {
    const auto& h = has[static_cast<std::size_t>(find(static_cast<std::int32_t>(v)))];
    if (!h[0] || !h[1]) return false;
  }
  return true;
}

// Minimises Σ V ∇uᵀ A ∇u with the held nodes at their values.
Result<Eigen::VectorXd> solve(const Problem& p, const std::string& name) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(p.held.size()));
  std::vector<std::uint8_t> fixed(p.held.size());
  for (std::size_t v = 0; v < p.held.size(); ++v) {
    fixed[v] = p.held[v] != Role::None;
    if (fixed[v]) u[static_cast<Eigen::Index>(v)] = p.value[v];
  }
  const mesh::StiffnessPattern pattern = mesh::stiffnessPattern(p.mesh, fixed);
  if (pattern.rowCount() == 0) return u;

  // Each element counts with the share of it that is muscle
  mesh::EdgeStiffness K = mesh::edgeStiffness(p.mesh, p.tensor);
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(pattern.rowCount(), 1);
  for (Eigen::Index t = 0; t < p.mesh.T.rows(); ++t) {
    auto& k = K.k[static_cast<std::size_t>(t)];
    const double share = p.volume[static_cast<std::size_t>(t)] / mesh::signedVolume(p.mesh, t);
    for (std::size_t e = 0; e < 6; ++e) {
      k[e] *= share;
      const std::int32_t a = p.mesh.T(t, mesh::kTetEdge[e][0]);
      const std::int32_t b = p.mesh.T(t, mesh::kTetEdge[e][1]);
      const std::int32_t rowA = pattern.row[static_cast<std::size_t>(a)];
      const std::int32_t rowB = pattern.row[static_cast<std::size_t>(b)];
      if (rowA >= 0 && rowB < 0) x(rowA, 0) -= k[e] * u[b];
      if (rowB >= 0 && rowA < 0) x(rowB, 0) -= k[e] * u[a];
    }
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
  for (std::int32_t r = 0; r < pattern.rowCount(); ++r)
    u[pattern.vertex[static_cast<std::size_t>(r)]] = x(r, 0);
  return u;
}

// Tets of specks carry no flow.
bool flows(const MuscleMesh& muscle, const SelectedEnds& ends, Eigen::Index t) {
  return !ends.speck[static_cast<std::size_t>(muscle.component[static_cast<std::size_t>(t)])];
}

// Nodes and elements with both numberings, and which element every tet of the muscle lies in.
struct Discretised {
  Problem problem;
  std::vector<std::int32_t> nodeId;   // node → domain or muscle vertex, ascending
  std::vector<std::int32_t> element;  // per muscle tet, -1 in specks

  [[nodiscard]] std::int32_t node(std::int32_t id) const {
    const auto at = std::ranges::lower_bound(nodeId, id);
    return at != nodeId.end() && *at == id ? static_cast<std::int32_t>(at - nodeId.begin()) : -1;
  }
  void hold(std::int32_t n, const EndValues& values) {
    problem.held[static_cast<std::size_t>(n)] = values.role;
    problem.value[static_cast<std::size_t>(n)] = values.at(problem.mesh.V.row(n).transpose());
  }
};

Discretised discretise(const MuscleMesh& muscle, const SelectedEnds& ends, const CurveGuide& guide,
                       const std::vector<CurveGuide::Nearest>& nearestOfTet,
                       const FiberOptions& options, const mesh::TetMesh& whole,
                       const std::vector<std::int32_t>& elementId) {
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
  p.held.assign(d.nodeId.size(), Role::None);
  p.value.assign(d.nodeId.size(), 0.0);
  return d;
}

// The domain's vertices that hold the value of an end: the end's own, and corners outside the
// muscle of the edges and faces that its new vertices lie on. With `all`, every such corner.
void holdDomainNodes(Discretised& d, const MuscleMesh& muscle, const envelope::Anatomy& anatomy,
                     const SelectedEnds& ends, std::int32_t domainVertexCount, bool all) {
  const auto localVertex = [&](std::int32_t id) {
    const auto at = std::ranges::lower_bound(muscle.vertexId, id);
    return at != muscle.vertexId.end() && *at == id ? at - muscle.vertexId.begin() : -1;
  };
  for (std::size_t v = 0; v < muscle.vertexId.size(); ++v) {
    if (ends.end[v] < 0) continue;
    const EndValues& values = ends.values[static_cast<std::size_t>(ends.end[v])];
    const std::int32_t id = muscle.vertexId[v];
    if (id < domainVertexCount) {
      const std::int32_t node = d.node(id);
      if (node >= 0) d.hold(node, values);
      continue;
    }
    const auto& origin = anatomy.origin[static_cast<std::size_t>(id - domainVertexCount)];
    for (std::size_t k = 0; k < 4; ++k) {
      if (origin.corner[k] < 0) continue;
      const std::int32_t node = d.node(origin.corner[k]);
      if (node < 0) continue;
      const bool outside = localVertex(origin.corner[k]) < 0;
      const bool free = d.problem.held[static_cast<std::size_t>(node)] == Role::None;
      if ((outside || all) && free) d.hold(node, values);
    }
  }
}

FlowPotential spreadToTets(const Discretised& d, const Eigen::VectorXd& nodeU,
                           Eigen::VectorXd vertexU) {
  FlowPotential flow;
  flow.u = std::move(vertexU);
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

Result<FlowPotential> solveOnDomainTets(const MuscleMesh& muscle, const envelope::Anatomy& anatomy,
                                        const domain::Domain& domain, const SelectedEnds& ends,
                                        const CurveGuide& guide,
                                        const std::vector<CurveGuide::Nearest>& nearestOfTet,
                                        const FiberOptions& options, const std::string& name) {
  std::vector<std::int32_t> parent(muscle.tetId.size());
  for (std::size_t t = 0; t < parent.size(); ++t) {
    parent[t] = anatomy.parentTet[static_cast<std::size_t>(muscle.tetId[t])];
  }
  Discretised d = discretise(muscle, ends, guide, nearestOfTet, options, domain.mesh, parent);
  const auto domainVertexCount = static_cast<std::int32_t>(domain.mesh.V.rows());
  holdDomainNodes(d, muscle, anatomy, ends, domainVertexCount, false);
  if (!everyGroupHeld(d.problem)) {
    holdDomainNodes(d, muscle, anatomy, ends, domainVertexCount, true);
  }
  if (!everyGroupHeld(d.problem)) {
    return fail(
        ErrorCode::FiberWithoutEnds,
        fmt::format("a piece of \"{}\" has no room between its ends; refine the domain there or "
                    "move the curve's ends apart",
                    name),
        {.object = name});
  }
  auto nodeU = solve(d.problem, name);
  if (!nodeU) return passOn(nodeU);

  // New vertices lie on the domain's tets, where u is linear
  Eigen::VectorXd u = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(muscle.vertexId.size()));
  for (std::size_t v = 0; v < muscle.vertexId.size(); ++v) {
    const std::int32_t id = muscle.vertexId[v];
    double value = 0.0;
    if (id < domainVertexCount) {
      const std::int32_t node = d.node(id);
      value = node >= 0 ? (*nodeU)[node] : 0.0;
    } else {
      const auto& origin = anatomy.origin[static_cast<std::size_t>(id - domainVertexCount)];
      for (std::size_t k = 0; k < 4; ++k) {
        const std::int32_t node = origin.corner[k] < 0 ? -1 : d.node(origin.corner[k]);
        if (node >= 0) value += origin.weight[k] * (*nodeU)[node];
      }
    }
    u[static_cast<Eigen::Index>(v)] = value;
  }
  return spreadToTets(d, *nodeU, std::move(u));
}

Result<FlowPotential> solveOnAnatomyTets(const MuscleMesh& muscle, const SelectedEnds& ends,
                                         const CurveGuide& guide,
                                         const std::vector<CurveGuide::Nearest>& nearestOfTet,
                                         const FiberOptions& options, const std::string& name) {
  std::vector<std::int32_t> itself(muscle.tetId.size());
  std::iota(itself.begin(), itself.end(), 0);
  Discretised d = discretise(muscle, ends, guide, nearestOfTet, options, muscle.mesh, itself);
  for (std::size_t n = 0; n < d.nodeId.size(); ++n) {
    const std::int32_t end = ends.end[static_cast<std::size_t>(d.nodeId[n])];
    if (end >= 0) d.hold(static_cast<std::int32_t>(n), ends.values[static_cast<std::size_t>(end)]);
  }
  auto nodeU = solve(d.problem, name);
  if (!nodeU) return passOn(nodeU);
  Eigen::VectorXd u = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(muscle.vertexId.size()));
  for (std::size_t n = 0; n < d.nodeId.size(); ++n)
    u[d.nodeId[n]] = (*nodeU)[static_cast<Eigen::Index>(n)];
  return spreadToTets(d, *nodeU, std::move(u));
}

}  // namespace

Result<FlowPotential> solveFlow(const MuscleMesh& muscle, const envelope::Anatomy& anatomy,
                                const domain::Domain& domain, const SelectedEnds& ends,
                                const CurveGuide& guide,
                                const std::vector<CurveGuide::Nearest>& nearestOfTet,
                                const FiberOptions& options, const std::string& name) {
  EC_REQUIRE_EQ(nearestOfTet.size(), muscle.tetId.size());
  if (options.elements == FlowElements::AnatomyTets) {
    return solveOnAnatomyTets(muscle, ends, guide, nearestOfTet, options, name);
  }
  return solveOnDomainTets(muscle, anatomy, domain, ends, guide, nearestOfTet, options, name);
}

}  // namespace ecorche::fiber
