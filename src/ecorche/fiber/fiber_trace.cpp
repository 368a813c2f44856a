#include <ecorche/fiber/fiber_trace.h>
#include <ecorche/mesh/operators.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace ecorche::fiber {

using mesh::Vector3;

namespace {

struct Seed {
  std::int32_t tet = -1;
  Vector3 point;
};

// Section of one tet by u = ½: its corners in order about the middle, empty where there is none.
std::vector<Vector3> section(const MuscleMesh& m, const Eigen::VectorXd& u, Eigen::Index t) {
  std::vector<Vector3> corners;
  for (const auto& e : mesh::kTetEdge) {
    const std::int32_t a = m.mesh.T(t, e[0]);
    const std::int32_t b = m.mesh.T(t, e[1]);
    if ((u[a] < 0.5) == (u[b] < 0.5)) continue;
    const double s = (0.5 - u[a]) / (u[b] - u[a]);
    corners.emplace_back((1.0 - s) * m.mesh.V.row(a).transpose() + s * m.mesh.V.row(b).transpose());
  }
  // Edge order crosses over in a quad: the two diagonal pairs are (first, last) and the middle two
  if (corners.size() == 4) std::swap(corners[2], corners[3]);
  return corners;
}

// Seeds at equal steps of cumulative section area, in the order of tets: the same for any number of
// threads.
std::vector<Seed> placeSeeds(const MuscleMesh& m, const Eigen::VectorXd& u, int count) {
  std::vector<double> cumulative;
  std::vector<Seed> candidates;
  double total = 0.0;
  for (Eigen::Index t = 0; t < m.mesh.T.rows(); ++t) {
    const std::vector<Vector3> p = section(m, u, t);
    if (p.size() < 3) continue;
    Vector3 middle = Vector3::Zero();
    for (const Vector3& x : p) middle += x / static_cast<double>(p.size());
    double area = 0.0;
    for (std::size_t k = 0; k < p.size(); ++k) {
      area += 0.5 * (p[k] - middle).cross(p[(k + 1) % p.size()] - middle).norm();
    }
    if (!(area > 0.0)) continue;
    total += area;
    cumulative.push_back(total);
    candidates.push_back({static_cast<std::int32_t>(t), middle});
  }
  std::vector<Seed> seeds;
  for (int k = 0; k < count && !candidates.empty(); ++k) {
    const auto at = std::ranges::upper_bound(cumulative, total * (k + 0.5) / count);
    seeds.push_back(candidates[static_cast<std::size_t>(
        std::min<std::ptrdiff_t>(at - cumulative.begin(), std::ssize(candidates) - 1))]);
  }
  return seeds;
}

// A point that walks through the tets of one muscle.
class Walker {
 public:
  Walker(const MuscleMesh& muscle, const Eigen::VectorXd& u, const mesh::Directions& fiber,
         const std::vector<std::uint8_t>& attached)
      : m_(muscle), u_(u), fiber_(fiber), attached_(attached) {}

  void place(std::int32_t tet, const Vector3& x) {
    tet_ = tet;
    x_ = x;
  }
  [[nodiscard]] const Vector3& point() const { return x_; }
  [[nodiscard]] double flow() const { return interpolate(weights(tet_, x_)); }

  // Moves by about `step` along the fibres (sign −1: against them). False where the fibre leaves
  // through an end.
  bool advance(double step, double sign) {
    const Vector3 first = sign * direction();
    // Midpoint rule; where the middle is outside, the first direction has to do
    const Vector3 start = x_;
    const std::int32_t startTet = tet_;
    const Exit half = walk(0.5 * step * first);
    const Vector3 middle = sign * direction();
    place(startTet, start);
    return settle(walk(step * (half == Exit::None ? middle : first)));
  }

 private:
  enum class Exit { None, Side, End };

  [[nodiscard]] Eigen::Vector4d weights(std::int32_t t, const Vector3& x) const {
    return mesh::barycentric(m_.mesh, t, x);
  }
  [[nodiscard]] double interpolate(const Eigen::Vector4d& w) const {
    double sum = 0.0;
    for (int k = 0; k < 4; ++k) sum += w[k] * u_[m_.mesh.T(tet_, k)];
    return sum;
  }
  [[nodiscard]] Vector3 direction() const {
    const Eigen::Vector4d w = weights(tet_, x_).cwiseMax(0.0);
    Vector3 d = Vector3::Zero();
    for (int k = 0; k < 4; ++k) d += w[k] * fiber_.row(m_.mesh.T(tet_, k)).transpose();
    const double norm = d.norm();
    return norm > 0.0 ? Vector3(d / norm) : Vector3(fiber_.row(m_.mesh.T(tet_, 0)).transpose());
  }

  // Straight on by `move` from tet to tet. At the muscle's surface it stops, tells how, and
  // remembers the face.
  Exit walk(const Vector3& move) {
    const Vector3 goal = x_ + move;
    for (int hops = 0; hops < 10000; ++hops) {
      const Eigen::Vector4d from = weights(tet_, x_);
      const Eigen::Vector4d to = weights(tet_, goal);
      int out = -1;
      double share = 1.0;
      for (int k = 0; k < 4; ++k) {
        if (to[k] >= 0.0) continue;
        const double drop = from[k] - to[k];
        const double s = drop > 0.0 ? std::max(0.0, from[k]) / drop : 1.0;
        if (out < 0 || s < share) {
          out = k;
          share = s;
        }
      }
      if (out < 0) {
        x_ = goal;
        return Exit::None;
      }
      x_ += std::min(share, 1.0) * (goal - x_);
      const std::int32_t next = m_.neighbours(tet_, out);
      if (next < 0) {
        exitCorner_ = out;
        remaining_ = goal - x_;
        return isEnd(out) ? Exit::End : Exit::Side;
      }
      tet_ = next;
    }
    return Exit::Side;
  }

  [[nodiscard]] bool isEnd(int corner) const {
    for (const int c : mesh::kTetFace[corner]) {
      if (!attached_[static_cast<std::size_t>(m_.mesh.T(tet_, c))]) return false;
    }
    return true;
  }

  // After a walk that met the surface: fibres run along sides, so slide on without the outward
  // part.
  bool settle(Exit exit) {
    for (int slides = 0; exit == Exit::Side && slides < 4; ++slides) {
      const auto& face = mesh::kTetFace[exitCorner_];
      const Vector3 a = m_.mesh.V.row(m_.mesh.T(tet_, face[0])).transpose();
      const Vector3 b = m_.mesh.V.row(m_.mesh.T(tet_, face[1])).transpose();
      const Vector3 c = m_.mesh.V.row(m_.mesh.T(tet_, face[2])).transpose();
      const Vector3 normal = (b - a).cross(c - a).normalized();
      const Vector3 inward = m_.centroid(tet_) - x_;
      x_ += 1e-3 * inward;
      exit = walk(remaining_ - remaining_.dot(normal) * normal);
    }
    return exit != Exit::End;
  }

  const MuscleMesh& m_;
  const Eigen::VectorXd& u_;
  const mesh::Directions& fiber_;
  const std::vector<std::uint8_t>& attached_;
  std::int32_t tet_ = -1;
  Vector3 x_ = Vector3::Zero();
  int exitCorner_ = 0;
  Vector3 remaining_ = Vector3::Zero();
};

// From a seed in one direction through an end or to the value `goal`; nothing where the fibre stops
// on the way.
std::optional<std::vector<Vector3>> follow(Walker walker, const Seed& seed, double sign,
                                           double step, double goal) {
  walker.place(seed.tet, seed.point);
  std::vector<Vector3> line{seed.point};
  double best = sign * walker.flow();
  int idle = 0;
  while (line.size() < 5000) {
    const bool inside = walker.advance(step, sign);
    line.push_back(walker.point());
    if (!inside) return line;
    const double flow = sign * walker.flow();
    if (flow >= sign * goal) return line;
    idle = flow > best ? 0 : idle + 1;
    best = std::max(best, flow);
    if (idle < 8) continue;
    // On the rim of an attachment a fibre may run into its corner
    line.resize(line.size() - static_cast<std::size_t>(idle));
    const double remaining = sign > 0.0 ? 1.0 - best : -best;
    if (remaining < 0.05) return line;
    return std::nullopt;
  }
  return std::nullopt;
}

double lengthOf(const std::vector<Vector3>& line) {
  double sum = 0.0;
  for (std::size_t k = 1; k < line.size(); ++k) sum += (line[k] - line[k - 1]).norm();
  return sum;
}

}  // namespace

TracedFibers traceFibers(const MuscleMesh& muscle, const Eigen::VectorXd& u,
                         const mesh::Directions& vertexFiber,
                         const std::vector<std::uint8_t>& attached, int count, double step,
                         double share) {
  TracedFibers out;
  // Values on a slanted attachment spread about 0 and 1: without tendon only its faces tell where a
  // fibre ends
  constexpr double kNever = 10.0;
  const double first = share > 0.0 ? share : -kNever;
  const double last = share > 0.0 ? 1.0 - share : kNever;
  const Walker walker(muscle, u, vertexFiber, attached);
  for (const Seed& seed : placeSeeds(muscle, u, count)) {
    const auto back = follow(walker, seed, -1.0, step, first);
    const auto on = follow(walker, seed, 1.0, step, last);
    if (!back || !on) continue;
    std::vector<Vector3> line(back->rbegin(), back->rend());
    line.insert(line.end(), on->begin() + 1, on->end());
    out.length.push_back(lengthOf(line));
    out.lines.push_back(std::move(line));
  }
  return out;
}

}  // namespace ecorche::fiber
