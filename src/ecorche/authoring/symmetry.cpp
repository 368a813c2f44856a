#include <ecorche/authoring/symmetry.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/surface_query.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace ecorche::authoring {

namespace {

using mesh::Vector3;

struct Plane {
  Vector3 point;
  Vector3 normal;
  [[nodiscard]] Vector3 mirrored(const Vector3& p) const {
    return p - 2.0 * (p - point).dot(normal) * normal;
  }
};

// Points spread evenly over the area, the same for every run: equal steps along the cumulated area,
// and a Kronecker sequence inside the triangles [Roberts 2018].
std::vector<Vector3> pointsOn(const mesh::SurfaceMesh& skin, int count) {
  std::vector<double> upTo;
  double area = 0.0;
  const auto corner = [&](Eigen::Index f, int k) -> Vector3 { return skin.V.row(skin.F(f, k)); };
  for (Eigen::Index f = 0; f < skin.F.rows(); ++f) {
    const Vector3 a = corner(f, 0);
    area += 0.5 * (corner(f, 1) - a).cross(corner(f, 2) - a).norm();
    upTo.push_back(area);
  }
  std::vector<Vector3> points;
  if (!(area > 0.0)) return points;
  for (int k = 0; k < count; ++k) {
    const auto face = std::ranges::upper_bound(upTo, area * (k + 0.5) / count) - upTo.begin();
    const auto f = std::min<Eigen::Index>(face, skin.F.rows() - 1);
    double s = std::fmod(0.5 + 0.7548776662466927 * k, 1.0);
    double t = std::fmod(0.5 + 0.5698402909980532 * k, 1.0);
    if (s + t > 1.0) {
      s = 1.0 - s;
      t = 1.0 - t;
    }
    const Vector3 a = corner(f, 0);
    points.push_back(a + s * (corner(f, 1) - a) + t * (corner(f, 2) - a));
  }
  return points;
}

// Where the points land in the mirror: nearest places on the surface, and how far they miss it.
struct Landing {
  std::vector<Vector3> place;
  std::vector<double> miss;
  double mean = 0.0;
};
Landing land(const std::vector<Vector3>& points, const Plane& plane,
             const mesh::SurfaceQuery& surface) {
  Landing out;
  out.place.resize(points.size());
  out.miss.resize(points.size());
  parallelFor(
      static_cast<std::int64_t>(points.size()),
      [&](std::int64_t k) {
        const auto i = static_cast<std::size_t>(k);
        const auto closest = surface.closest(plane.mirrored(points[i]));
        out.place[i] = closest.point;
        out.miss[i] = closest.distance;
      },
      64);
  for (double miss : out.miss) out.mean += miss / static_cast<double>(points.size());
  return out;
}

// The plane whose mirror takes p_k nearest to q_k in the least-squares sense. It passes through the
// middle of the two centroids; with p, q taken from their centroids, |p − 2n(n·p) − q|² = |p − q|²
// + 4 (n·p)(n·q), so n is the eigenvector of Σ (pqᵀ + qpᵀ)/2 with the smallest eigenvalue.
Plane bestPlane(const std::vector<Vector3>& points, const Landing& landing) {
  // The worst fifth has no say: a bent limb, a tail to one side
  std::vector<double> sorted = landing.miss;
  const auto cut = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 4 / 5);
  std::ranges::nth_element(sorted, cut);
  Vector3 p0 = Vector3::Zero(), q0 = Vector3::Zero();
  double count = 0.0;
  const auto each = [&](const auto& act) {
    for (std::size_t k = 0; k < points.size(); ++k) {
      if (landing.miss[k] <= *cut) act(points[k], landing.place[k]);
    }
  };
  each([&](const Vector3& p, const Vector3& q) {
    p0 += p;
    q0 += q;
    count += 1.0;
  });
  p0 /= count;
  q0 /= count;
  Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
  each([&](const Vector3& p, const Vector3& q) {
    const Eigen::Matrix3d outer = (p - p0) * (q - q0).transpose();
    S += 0.5 * (outer + outer.transpose());
  });
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(S);
  return {0.5 * (p0 + q0), eigen.eigenvectors().col(0)};
}

std::vector<Vector3> candidateNormals(const std::vector<Vector3>& points, const Vector3& centre) {
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Vector3& p : points) spread += (p - centre) * (p - centre).transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(spread);
  std::vector<Vector3> normals;
  for (int k = 0; k < 3; ++k) {
    normals.push_back(axes.eigenvectors().col(k));
    normals.push_back(Vector3::Unit(k));
  }
  // A half sphere in a spiral, for bodies whose principal axes say nothing: about 15° apart
  constexpr int kDirections = 64;
  for (int k = 0; k < kDirections; ++k) {
    const double z = (k + 0.5) / kDirections;
    const double angle = k * std::numbers::pi * (3.0 - std::sqrt(5.0));
    const double r = std::sqrt(1.0 - z * z);
    normals.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return normals;
}

}  // namespace

Result<std::optional<SymmetryPlane>> findSymmetryPlane(const mesh::SurfaceMesh& skin,
                                                       const SymmetryOptions& options,
                                                       RunContext& run) {
  const Stage stage(run, "symmetry plane");
  const std::vector<Vector3> coarse = pointsOn(skin, 250);
  if (coarse.empty()) {
    return fail(ErrorCode::MeshWithoutFaces, "the skin has no faces to mirror",
                {.object = skin.name});
  }
  const std::vector<Vector3> fine = pointsOn(skin, 3000);
  const mesh::SurfaceQuery surface(skin);
  const double diagonal = mesh::boundingBox(skin).diagonal();
  Vector3 centre = Vector3::Zero();
  for (const Vector3& p : fine) centre += p / static_cast<double>(fine.size());

  const auto refined = [&](Plane plane, const std::vector<Vector3>& points, int rounds) {
    for (int round = 0; round < rounds && !run.cancelled(); ++round) {
      const Plane next = bestPlane(points, land(points, plane, surface));
      const double turned = 1.0 - std::abs(next.normal.dot(plane.normal));
      const double moved = std::abs((next.point - plane.point).dot(next.normal));
      plane = next;
      if (turned < 1e-14 && moved < 1e-7 * diagonal) break;
    }
    return plane;
  };

  // A few coarse rounds for all, many fine ones for the best
  struct Candidate {
    Plane plane;
    double miss;
  };
  std::vector<Candidate> candidates;
  for (const Vector3& normal : candidateNormals(fine, centre)) {
    const Plane plane = refined({centre, normal}, coarse, 4);
    candidates.push_back({plane, land(coarse, plane, surface).mean});
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "symmetry plane");
  }
  std::ranges::stable_sort(candidates, {}, &Candidate::miss);
  candidates.resize(std::min<std::size_t>(candidates.size(), 4));
  for (Candidate& candidate : candidates) {
    candidate.plane = refined(candidate.plane, coarse, 40);
    candidate.miss = land(coarse, candidate.plane, surface).mean;
  }
  Candidate best = *std::ranges::min_element(candidates, {}, &Candidate::miss);
  best.plane = refined(best.plane, fine, 40);
  best.miss = land(fine, best.plane, surface).mean;
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "symmetry plane");
  if (best.miss > options.tolerance * diagonal) return std::optional<SymmetryPlane>();

  SymmetryPlane out;
  Eigen::Index largest = 0;
  best.plane.normal.cwiseAbs().maxCoeff(&largest);
  if (best.plane.normal[largest] < 0.0) best.plane.normal = -best.plane.normal;

  // Modellers mirror about a plane of their frame: take it where it is as good
  const Plane own{Vector3::Zero(), Vector3::Unit(largest)};
  const bool near = best.plane.normal[largest] > std::cos(0.01) &&
                    std::abs(best.plane.point.dot(best.plane.normal)) < 0.005 * diagonal;
  if (near) {
    const double miss = land(fine, own, surface).mean;
    if (miss < best.miss + 2e-4 * diagonal) {
      best = {own, miss};
      out.snapped = true;
    }
  }
  out.normal = best.plane.normal;
  out.point = best.plane.point.dot(out.normal) * out.normal;
  out.error = best.miss / diagonal;
  return std::optional(out);
}

}  // namespace ecorche::authoring
