#include <ecorche/core/parallel.h>
#include <ecorche/mesh/tet_mesh.h>
#include <tbb/parallel_sort.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace ecorche::mesh {

double signedVolume(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  return (b - a).cross(c - a).dot(d - a) / 6.0;
}

double signedVolume(const TetMesh& mesh, Eigen::Index t) {
  return signedVolume(mesh.V.row(mesh.T(t, 0)).transpose(), mesh.V.row(mesh.T(t, 1)).transpose(),
                      mesh.V.row(mesh.T(t, 2)).transpose(), mesh.V.row(mesh.T(t, 3)).transpose());
}

Eigen::VectorXd signedVolumes(const TetMesh& mesh) {
  Eigen::VectorXd volumes(mesh.T.rows());
  parallelFor(mesh.T.rows(), [&](std::int64_t t) { volumes[t] = signedVolume(mesh, t); });
  return volumes;
}

Eigen::VectorXd meanEdgeLengths(const TetMesh& mesh) {
  Eigen::VectorXd lengths(mesh.T.rows());
  parallelFor(mesh.T.rows(), [&](std::int64_t t) {
    double sum = 0.0;
    for (const auto& e : kTetEdge) {
      sum += (mesh.V.row(mesh.T(t, e[0])) - mesh.V.row(mesh.T(t, e[1]))).norm();
    }
    lengths[t] = sum / 6.0;
  });
  return lengths;
}

namespace {
struct FaceKey {
  std::array<std::int32_t, 3> v;  // ascending
  std::int32_t slot;              // 4·tet + corner
  auto operator<=>(const FaceKey&) const = default;
};
}  // namespace

TetAdjacency tetAdjacency(const Tets& T) {
  std::vector<FaceKey> faces(static_cast<std::size_t>(T.rows()) * 4);
  parallelFor(T.rows(), [&](std::int64_t t) {
    for (int k = 0; k < 4; ++k) {
      FaceKey key{{T(t, kTetFace[k][0]), T(t, kTetFace[k][1]), T(t, kTetFace[k][2])},
                  static_cast<std::int32_t>(4 * t + k)};
      std::ranges::sort(key.v);
      faces[static_cast<std::size_t>(4 * t + k)] = key;
    }
  });
  tbb::parallel_sort(faces.begin(), faces.end());

  TetAdjacency out;
  out.neighbours.setConstant(T.rows(), 4, -1);
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t j = i + 1;
    while (j < faces.size() && faces[j].v == faces[i].v) ++j;
    if (j - i == 2) {
      const std::int32_t a = faces[i].slot;
      const std::int32_t b = faces[i + 1].slot;
      out.neighbours(a / 4, a % 4) = b / 4;
      out.neighbours(b / 4, b % 4) = a / 4;
    } else if (j - i > 2) {
      ++out.nonManifoldFaces;
    }
    i = j;
  }
  return out;
}

TetBoundary tetBoundary(const Tets& T, const TetNeighbours& neighbours) {
  Eigen::Index count = 0;
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    for (int k = 0; k < 4; ++k) count += neighbours(t, k) < 0;
  }
  TetBoundary out;
  out.F.resize(count, 3);
  out.tet.reserve(static_cast<std::size_t>(count));
  Eigen::Index f = 0;
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    for (int k = 0; k < 4; ++k) {
      if (neighbours(t, k) >= 0) continue;
      for (int c = 0; c < 3; ++c) out.F(f, c) = T(t, kTetFace[k][c]);
      out.tet.push_back(static_cast<std::int32_t>(t));
      ++f;
    }
  }
  return out;
}

VertexTets vertexTets(const Tets& T, Eigen::Index vertexCount) {
  VertexTets out;
  out.first.assign(static_cast<std::size_t>(vertexCount) + 1, 0);
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    for (int k = 0; k < 4; ++k) ++out.first[static_cast<std::size_t>(T(t, k)) + 1];
  }
  for (std::size_t v = 1; v < out.first.size(); ++v) out.first[v] += out.first[v - 1];
  std::vector<std::int32_t> next(out.first.begin(), out.first.end() - 1);
  out.tet.resize(static_cast<std::size_t>(T.rows()) * 4);
  for (Eigen::Index t = 0; t < T.rows(); ++t) {
    for (int k = 0; k < 4; ++k) {
      out.tet[static_cast<std::size_t>(next[static_cast<std::size_t>(T(t, k))]++)] =
          static_cast<std::int32_t>(t);
    }
  }
  return out;
}

Eigen::MatrixX2d dihedralRangeDeg(const TetMesh& mesh) {
  Eigen::MatrixX2d range(mesh.T.rows(), 2);
  parallelFor(mesh.T.rows(), [&](std::int64_t t) {
    // Angle between the outward normals of two faces is π minus the dihedral at their common edge
    Vector3 n[4];
    for (int k = 0; k < 4; ++k) {
      const Vector3 a = mesh.V.row(mesh.T(t, kTetFace[k][0])).transpose();
      const Vector3 b = mesh.V.row(mesh.T(t, kTetFace[k][1])).transpose();
      const Vector3 c = mesh.V.row(mesh.T(t, kTetFace[k][2])).transpose();
      n[k] = (b - a).cross(c - a);
    }
    double lo = std::numbers::pi;
    double hi = 0.0;
    for (const auto& e : kTetEdge) {
      const double angle =
          std::numbers::pi - std::atan2(n[e[0]].cross(n[e[1]]).norm(), n[e[0]].dot(n[e[1]]));
      lo = std::min(lo, angle);
      hi = std::max(hi, angle);
    }
    range(t, 0) = lo * 180.0 / std::numbers::pi;
    range(t, 1) = hi * 180.0 / std::numbers::pi;
  });
  return range;
}

}  // namespace ecorche::mesh
