#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/well.h>
#include <ecorche/tissue/well_radius.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
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

// The tets around p, their vertices, and which of those are unknown. Lengths in reaches, so that
// units cancel.
struct Patch {
  struct Node {
    Vector3 at;        // from p
    bool free = true;  // within reach and not on the boundary
    std::int32_t row = -1;
    double line = 0.0;  // the line's field where it is prescribed
  };
  std::vector<std::array<std::int32_t, 4>> tets;  // nodes of each; the first holds p
  std::vector<Node> nodes;
  std::int32_t rowCount = 0;
};

Patch gather(const Domain& domain, std::int32_t tet, const Vector3& p, double reach) {
  Patch patch;
  Arrivals nodeOf;
  Arrivals seen;
  std::vector<std::int32_t> queue{tet};
  (void)seen.add(tet);
  // The star of a vertex hangs together through faces, so tets with a corner within reach are found
  // face by face
  for (std::size_t i = 0; i < queue.size(); ++i) {
    std::array<std::int32_t, 4> n{};
    for (int k = 0; k < 4; ++k) {
      const std::int32_t v = domain.mesh.T(queue[i], k);
      const auto [place, fresh] = nodeOf.add(v);
      if (fresh) {
        const Vector3 at = (domain.mesh.V.row(v).transpose() - p) / reach;
        patch.nodes.push_back({at, at.squaredNorm() < 1.0, -1, 0.0});
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

}  // namespace

double wellRadius(const Domain& domain, std::int32_t tet, const Vector3& p, const Vector3& tangent,
                  double h) {
  const double reach = kWellReach * h;
  Patch patch = gather(domain, tet, p, reach);

  // Field of a line of unit flux; a vertex of the boundary may lie on the line itself
  for (Patch::Node& node : patch.nodes) {
    if (node.free) continue;
    const double r = (node.at - node.at.dot(tangent) * tangent).norm();
    node.line = -std::log(std::max(r, 0.1)) / (2.0 * std::numbers::pi);
  }
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(patch.rowCount, patch.rowCount);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(patch.rowCount);
  Eigen::Vector4d own;  // barycentric coordinates of p in its tet
  Vector3 nudge = Vector3::Zero();
  for (std::size_t t = 0; t < patch.tets.size(); ++t) {
    std::array<const Patch::Node*, 4> node{};
    for (std::size_t k = 0; k < 4; ++k) {
      node[k] = &patch.nodes[static_cast<std::size_t>(patch.tets[t][k])];
    }
    // Rows of G are V ∇λ, since slivers have next to no V: n / 3 with n the face normals
    const Vector3 e1 = node[1]->at - node[0]->at;
    const Vector3 e2 = node[2]->at - node[0]->at;
    const Vector3 e3 = node[3]->at - node[0]->at;
    Eigen::Matrix<double, 4, 3> VG;
    VG.row(1) = e2.cross(e3).transpose() / 6.0;
    VG.row(2) = e3.cross(e1).transpose() / 6.0;
    VG.row(3) = e1.cross(e2).transpose() / 6.0;
    VG.row(0) = -(VG.row(1) + VG.row(2) + VG.row(3));
    const double V = std::max(e1.dot(VG.row(1)), mesh::kFlattest);
    const double perV = 1.0 / V;
    for (std::size_t i = 0; i < 4; ++i) {
      if (node[i]->row < 0) continue;
      for (std::size_t j = 0; j < 4; ++j) {
        if (node[j]->row > node[i]->row) continue;  // the lower triangle is enough
        const double k = perV * VG.row(static_cast<int>(i)).dot(VG.row(static_cast<int>(j)));
        if (node[j]->row >= 0) {
          K(node[i]->row, node[j]->row) += k;
        } else {
          b[node[i]->row] -= k * node[j]->line;
        }
      }
    }
    Eigen::Vector4d at;
    for (int k = 0; k < 4; ++k) {
      at[k] = -VG.row(k).dot(node[static_cast<std::size_t>((k + 1) % 4)]->at) * perV;
    }
    if (t == 0) {
      own = at;
      nudge = 1e-6 * 0.25 * (node[0]->at + node[1]->at + node[2]->at + node[3]->at);
    }
    // The piece of line inside: coordinates are linear along it. A line in a common face would
    // count twice or not at all, so it is moved into the tet of p by a hair.
    at += perV * (VG * nudge);
    const Eigen::Vector4d slope = perV * (VG * tangent);
    double s0 = -std::numeric_limits<double>::infinity();
    double s1 = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 4; ++k) {
      const double s = -at[k] / slope[k];
      if (slope[k] > 0.0) s0 = std::max(s0, s);
      if (slope[k] < 0.0) s1 = std::min(s1, s);
      if (slope[k] == 0.0 && at[k] < 0.0) s1 = s0;
    }
    if (!(s1 > s0) || !std::isfinite(s1 - s0)) continue;
    const Eigen::Vector4d middle = at + 0.5 * (s0 + s1) * slope;
    for (std::size_t k = 0; k < 4; ++k) {
      if (node[k]->row >= 0) b[node[k]->row] += (s1 - s0) * middle[static_cast<int>(k)];
    }
  }

  const double guess = kWellC * h;
  const Eigen::LLT<Eigen::MatrixXd> factor(K);
  if (factor.info() != Eigen::Success) return guess;
  const Eigen::VectorXd u = factor.solve(b);
  double reads = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const Patch::Node& node = patch.nodes[static_cast<std::size_t>(patch.tets[0][k])];
    reads += own[static_cast<int>(k)] * (node.row >= 0 ? u[node.row] : node.line);
  }
  const double radius = reach * std::exp(-2.0 * std::numbers::pi * reads);
  if (!std::isfinite(radius)) return guess;
  return std::clamp(radius, kLeastWell * guess, guess / kLeastWell);
}

}  // namespace ecorche::tissue
