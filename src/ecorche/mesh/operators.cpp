#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/operators.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace ecorche::mesh {

namespace {

Vector3 corner(const TetMesh& mesh, Eigen::Index t, int k) {
  return mesh.V.row(mesh.T(t, k)).transpose();
}

// n_k = 3V ∇λ_k: normals of the faces with the length of their area, pointing to the corner
// opposite.
struct FaceNormals {
  std::array<Vector3, 4> n;
  double sixV;

  FaceNormals(const TetMesh& mesh, Eigen::Index t) {
    const Vector3 a = corner(mesh, t, 0);
    const Vector3 b = corner(mesh, t, 1) - a;
    const Vector3 c = corner(mesh, t, 2) - a;
    const Vector3 d = corner(mesh, t, 3) - a;
    n[1] = 0.5 * c.cross(d);
    n[2] = 0.5 * d.cross(b);
    n[3] = 0.5 * b.cross(c);
    n[0] = -(n[1] + n[2] + n[3]);
    sixV = 2.0 * b.dot(n[1]);
  }
};

double meanEdge(const TetMesh& mesh, Eigen::Index t) {
  double sum = 0.0;
  for (const auto& e : kTetEdge) sum += (corner(mesh, t, e[0]) - corner(mesh, t, e[1])).norm();
  return sum / 6.0;
}

// One tet's entries; whether it was flattened. Flux is what it turns a gradient into: the identity,
// or its tensor A.
template <class Flux>
bool stiffnessOf(const TetMesh& mesh, Eigen::Index t, const Flux& flux, std::array<double, 6>& k) {
  const FaceNormals face(mesh, t);
  const double h = meanEdge(mesh, t);
  double V = face.sixV / 6.0;
  // A Gram matrix over any positive number stays positive semidefinite, so the floor is safe
  const bool flat = !(V > kFlattest * h * h * h);
  if (flat) V = kFlattest * h * h * h;
  for (std::size_t e = 0; e < 6; ++e) {
    const Vector3& ni = face.n[static_cast<std::size_t>(kTetEdge[e][0])];
    const Vector3& nj = face.n[static_cast<std::size_t>(kTetEdge[e][1])];
    k[e] = ni.dot(flux(nj)) / (9.0 * V);
  }
  return flat;
}

// @param fluxIn  of every tet
template <class FluxIn>
EdgeStiffness edgeStiffnessWith(const TetMesh& mesh, const FluxIn& fluxIn) {
  EdgeStiffness out;
  out.k.resize(static_cast<std::size_t>(mesh.T.rows()));
  std::vector<std::uint8_t> flat(out.k.size(), 0);
  parallelFor(mesh.T.rows(), [&](std::int64_t t) {
    const auto slot = static_cast<std::size_t>(t);
    flat[slot] = stiffnessOf(mesh, t, fluxIn(slot), out.k[slot]) ? 1 : 0;
  });
  for (std::size_t t = 0; t < flat.size(); ++t) {
    if (flat[t] != 0) out.flattened.push_back(static_cast<std::int32_t>(t));
  }
  return out;
}

}  // namespace

Eigen::Matrix<double, 4, 3> barycentricGradients(const TetMesh& mesh, Eigen::Index tet) {
  const FaceNormals face(mesh, tet);
  Eigen::Matrix<double, 4, 3> G;
  for (int k = 0; k < 4; ++k) {
    G.row(k) = (2.0 / face.sixV) * face.n[static_cast<std::size_t>(k)].transpose();
  }
  return G;
}

Eigen::Vector4d barycentric(const TetMesh& mesh, Eigen::Index tet, const Vector3& p) {
  // From the four sub-volumes, each seen from p: near a face its own coordinate keeps all digits
  const Vector3 a = corner(mesh, tet, 0) - p;
  const Vector3 b = corner(mesh, tet, 1) - p;
  const Vector3 c = corner(mesh, tet, 2) - p;
  const Vector3 d = corner(mesh, tet, 3) - p;
  Eigen::Vector4d v(b.dot(d.cross(c)), a.dot(c.cross(d)), a.dot(d.cross(b)), a.dot(b.cross(c)));
  v = -v;
  const double sum = v.sum();
  if (!(std::abs(sum) > 0.0)) return Eigen::Vector4d::Constant(0.25);
  return v / sum;
}

Eigen::VectorXd lumpedMass(const TetMesh& mesh) {
  Eigen::VectorXd mass = Eigen::VectorXd::Zero(mesh.V.rows());
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    const double quarter = signedVolume(mesh, t) / 4.0;
    for (int k = 0; k < 4; ++k) mass[mesh.T(t, k)] += quarter;
  }
  return mass;
}

EdgeStiffness edgeStiffness(const TetMesh& mesh) {
  return edgeStiffnessWith(mesh, [](std::size_t) { return [](const Vector3& n) { return n; }; });
}

EdgeStiffness edgeStiffness(const TetMesh& mesh, std::span<const Eigen::Matrix3d> A) {
  EC_REQUIRE_EQ(A.size(), static_cast<std::size_t>(mesh.T.rows()));
  return edgeStiffnessWith(
      mesh, [&](std::size_t t) { return [&A, t](const Vector3& n) { return Vector3(A[t] * n); }; });
}

std::array<double, 6> edgeStiffness(const TetMesh& mesh, Eigen::Index tet,
                                    const Eigen::Matrix3d& A) {
  std::array<double, 6> out{};
  stiffnessOf(
      mesh, tet, [&](const Vector3& n) { return Vector3(A * n); }, out);
  return out;
}

StiffnessPattern stiffnessPattern(const TetMesh& mesh, const std::vector<std::uint8_t>& fixed) {
  EC_REQUIRE_EQ(fixed.size(), static_cast<std::size_t>(mesh.V.rows()));
  StiffnessPattern out;
  out.vertexTets = vertexTets(mesh.T, mesh.V.rows());
  out.row.assign(fixed.size(), -1);
  for (std::size_t v = 0; v < fixed.size(); ++v) {
    if (fixed[v] != 0) continue;
    out.row[v] = static_cast<std::int32_t>(out.vertex.size());
    out.vertex.push_back(static_cast<std::int32_t>(v));
  }

  // Rows below the diagonal of column r: free neighbours of its vertex with a higher row
  const auto neighboursBelow = [&](std::int32_t r, std::vector<std::int32_t>& below) {
    below.clear();
    const auto v = static_cast<std::size_t>(out.vertex[static_cast<std::size_t>(r)]);
    for (std::int32_t i = out.vertexTets.first[v]; i < out.vertexTets.first[v + 1]; ++i) {
      const auto t = out.vertexTets.tet[static_cast<std::size_t>(i)];
      for (int k = 0; k < 4; ++k) {
        const std::int32_t other = out.row[static_cast<std::size_t>(mesh.T(t, k))];
        if (other > r && std::ranges::find(below, other) == below.end()) below.push_back(other);
      }
    }
  };
  const auto rows = static_cast<std::int64_t>(out.vertex.size());
  out.first.assign(static_cast<std::size_t>(rows) + 1, 0);
  parallelFor(rows, [&](std::int64_t r) {
    thread_local std::vector<std::int32_t> below;
    neighboursBelow(static_cast<std::int32_t>(r), below);
    out.first[static_cast<std::size_t>(r) + 1] = static_cast<std::int32_t>(below.size()) + 1;
  });
  for (std::size_t r = 1; r < out.first.size(); ++r) out.first[r] += out.first[r - 1];
  out.index.resize(static_cast<std::size_t>(out.first.back()));
  parallelFor(rows, [&](std::int64_t r) {
    thread_local std::vector<std::int32_t> below;
    neighboursBelow(static_cast<std::int32_t>(r), below);
    std::ranges::sort(below);
    auto* column = out.index.data() + out.first[static_cast<std::size_t>(r)];
    *column = static_cast<std::int32_t>(r);
    std::ranges::copy(below, column + 1);
  });

  // Where each edge of each tet lands
  out.edgeSlot.resize(static_cast<std::size_t>(mesh.T.rows()));
  parallelFor(mesh.T.rows(), [&](std::int64_t t) {
    for (std::size_t e = 0; e < 6; ++e) {
      const std::int32_t i = out.row[static_cast<std::size_t>(mesh.T(t, kTetEdge[e][0]))];
      const std::int32_t j = out.row[static_cast<std::size_t>(mesh.T(t, kTetEdge[e][1]))];
      auto& slot = out.edgeSlot[static_cast<std::size_t>(t)][e];
      slot = -1;
      if (i < 0 || j < 0) continue;
      const auto column = static_cast<std::size_t>(std::min(i, j));
      const auto* begin = out.index.data() + out.first[column];
      const auto* end = out.index.data() + out.first[column + 1];
      slot = static_cast<std::int32_t>(std::lower_bound(begin, end, std::max(i, j)) -
                                       out.index.data());
    }
  });
  return out;
}

NeighbourRows neighbourRows(const StiffnessPattern& pattern) {
  NeighbourRows out;
  const auto n = static_cast<std::size_t>(pattern.rowCount());
  const auto entries = [&](std::size_t c) {
    return std::pair(static_cast<std::size_t>(pattern.first[c]) + 1,  // the diagonal comes first
                     static_cast<std::size_t>(pattern.first[c + 1]));
  };
  out.first.assign(n + 1, 0);
  for (std::size_t c = 0; c < n; ++c) {
    const auto [begin, end] = entries(c);
    out.first[c + 1] += static_cast<std::int32_t>(end - begin);
    for (std::size_t i = begin; i < end; ++i)
      ++out.first[static_cast<std::size_t>(pattern.index[i]) + 1];
  }
  std::partial_sum(out.first.begin(), out.first.end(), out.first.begin());
  out.neighbour.resize(static_cast<std::size_t>(out.first.back()));
  out.slot.resize(out.neighbour.size());
  std::vector<std::int32_t> next(out.first.begin(), out.first.end() - 1);
  for (std::size_t c = 0; c < n; ++c) {
    const auto [begin, end] = entries(c);
    for (std::size_t i = begin; i < end; ++i) {
      const auto r = static_cast<std::size_t>(pattern.index[i]);
      for (const auto& [from, to] : {std::pair(r, c), std::pair(c, r)}) {
        const auto at = static_cast<std::size_t>(next[from]++);
        out.neighbour[at] = static_cast<std::int32_t>(to);
        out.slot[at] = static_cast<std::int32_t>(i);
      }
    }
  }
  return out;
}

std::vector<double> assembleStiffness(const TetMesh& mesh, const StiffnessPattern& pattern,
                                      const EdgeStiffness& stiffness) {
  EC_REQUIRE_EQ(stiffness.k.size(), pattern.edgeSlot.size());
  static constexpr std::size_t kEdgesAt[4][3] = {{0, 1, 2}, {0, 3, 4}, {1, 3, 5}, {2, 4, 5}};
  std::vector<double> values(pattern.entryCount(), 0.0);
  parallelFor(pattern.rowCount(), [&](std::int64_t r) {
    const auto v = static_cast<std::size_t>(pattern.vertex[static_cast<std::size_t>(r)]);
    const std::int32_t begin = pattern.first[static_cast<std::size_t>(r)];
    const std::int32_t end = pattern.first[static_cast<std::size_t>(r) + 1];
    double diagonal = 0.0;
    for (std::int32_t i = pattern.vertexTets.first[v]; i < pattern.vertexTets.first[v + 1]; ++i) {
      const auto t = pattern.vertexTets.tet[static_cast<std::size_t>(i)];
      int k = 0;
      while (mesh.T(t, k) != static_cast<std::int32_t>(v)) ++k;
      for (const std::size_t e : kEdgesAt[k]) {
        const double kij = stiffness.k[static_cast<std::size_t>(t)][e];
        const std::int32_t slot = pattern.edgeSlot[static_cast<std::size_t>(t)][e];
        diagonal -= kij;
        if (slot > begin && slot < end) values[static_cast<std::size_t>(slot)] += kij;
      }
    }
    values[static_cast<std::size_t>(begin)] = diagonal;
  });
  return values;
}

}  // namespace ecorche::mesh
