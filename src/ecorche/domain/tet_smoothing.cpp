#include <ecorche/domain/tet_smoothing.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace ecorche::domain {

using mesh::Vector3;

namespace {

// Smallest sine of a dihedral angle of the tet, negative where it is turned inside out: cheap, and
// small for both kinds of bad angle
double worstSine(const Vector3& a, const Vector3& b, const Vector3& c, const Vector3& d) {
  const double six = (b - a).cross(c - a).dot(d - a);
  const Vector3 p[4] = {a, b, c, d};
  double area[4];
  for (int k = 0; k < 4; ++k) {
    area[k] = (p[mesh::kTetFace[k][1]] - p[mesh::kTetFace[k][0]])
                  .cross(p[mesh::kTetFace[k][2]] - p[mesh::kTetFace[k][0]])
                  .norm();
  }
  double worst = 1.0;
  for (const auto& e : mesh::kTetEdge) {
    // sin θ = 3 V l / (2 A B) with areas halved: six·l / (area·area)
    int f[2];
    int n = 0;
    for (int k = 0; k < 4; ++k) {
      if (k != e[0] && k != e[1]) f[n++] = k;
    }
    const double product = area[f[0]] * area[f[1]];
    if (!(product > 0.0)) return -1.0;
    worst = std::min(worst, six * (p[e[0]] - p[e[1]]).norm() / product);
  }
  return worst;
}

class Smoother {
 public:
  Smoother(mesh::TetMesh& mesh, const std::vector<std::uint8_t>& fixed)
      : mesh_(mesh), fixed_(fixed), around_(mesh::vertexTets(mesh.T, mesh.V.rows())) {}

  [[nodiscard]] double worstAround(std::int32_t v, const Vector3& at) const {
    double worst = 1.0;
    for (auto i = begin(v); i < end(v); ++i) {
      const std::int32_t t = around_.tet[i];
      Vector3 p[4];
      for (int k = 0; k < 4; ++k) {
        const std::int32_t w = mesh_.T(t, k);
        p[k] = w == v ? at : Vector3(mesh_.V.row(w).transpose());
      }
      worst = std::min(worst, worstSine(p[0], p[1], p[2], p[3]));
    }
    return worst;
  }

  bool improve(std::int32_t v) {
    const Vector3 from = mesh_.V.row(v).transpose();
    double best = worstAround(v, from);
    const double start = best;
    Vector3 at = from;
    Vector3 mean = Vector3::Zero();
    double reach = 0.0;
    int count = 0;
    for (auto i = begin(v); i < end(v); ++i) {
      for (int k = 0; k < 4; ++k) {
        const std::int32_t w = mesh_.T(around_.tet[i], k);
        if (w == v) continue;
        const Vector3 p = mesh_.V.row(w).transpose();
        mean += p;
        reach += (p - from).norm();
        ++count;
      }
    }
    mean /= count;
    reach /= count;
    const auto tryAt = [&](const Vector3& p) {
      const double q = worstAround(v, p);
      if (q <= best) return false;
      best = q;
      at = p;
      return true;
    };
    tryAt(mean);
    tryAt(0.5 * (mean + from));
    // Pattern search: six directions, step halved when none helps
    for (double step = 0.25 * reach; step > 0.01 * reach;) {
      bool better = false;
      for (int k = 0; k < 3; ++k) {
        better = tryAt(at + step * Vector3::Unit(k)) || better;
        better = tryAt(at - step * Vector3::Unit(k)) || better;
      }
      if (!better) step *= 0.5;
    }
    if (best <= start + 1e-6) return false;
    mesh_.V.row(v) = at.transpose();
    return true;
  }

  [[nodiscard]] bool isFixed(std::int32_t v) const {
    return fixed_[static_cast<std::size_t>(v)] != 0;
  }

 private:
  mesh::TetMesh& mesh_;
  const std::vector<std::uint8_t>& fixed_;
  mesh::VertexTets around_;

  [[nodiscard]] std::size_t begin(std::int32_t v) const {
    return static_cast<std::size_t>(around_.first[static_cast<std::size_t>(v)]);
  }
  [[nodiscard]] std::size_t end(std::int32_t v) const {
    return static_cast<std::size_t>(around_.first[static_cast<std::size_t>(v) + 1]);
  }
};

std::vector<std::int32_t> poorTets(const mesh::TetMesh& mesh, double limitDeg) {
  const Eigen::MatrixX2d range = mesh::dihedralRangeDeg(mesh);
  std::vector<std::int32_t> out;
  for (Eigen::Index t = 0; t < range.rows(); ++t) {
    if (range(t, 0) < limitDeg || range(t, 1) > 180.0 - limitDeg)
      out.push_back(static_cast<std::int32_t>(t));
  }
  return out;
}

}  // namespace

SmoothingResult smoothSlivers(mesh::TetMesh& mesh, const std::vector<std::uint8_t>& fixed,
                              double limitDeg, RunContext& run) {
  SmoothingResult out;
  Smoother smoother(mesh, fixed);
  for (int round = 0; round < 6 && !run.cancelled(); ++round) {
    const std::vector<std::int32_t> poor = poorTets(mesh, limitDeg);
    if (round == 0) out.before = static_cast<std::int64_t>(poor.size());
    out.after = static_cast<std::int64_t>(poor.size());
    std::set<std::int32_t> vertices;
    for (const std::int32_t t : poor) {
      for (int k = 0; k < 4; ++k) {
        if (!smoother.isFixed(mesh.T(t, k))) vertices.insert(mesh.T(t, k));
      }
    }
    std::int64_t moved = 0;
    for (const std::int32_t v : vertices) moved += smoother.improve(v);
    out.moved += moved;
    if (moved == 0) break;
  }
  out.after = static_cast<std::int64_t>(poorTets(mesh, limitDeg).size());
  return out;
}

}  // namespace ecorche::domain
