#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/surface_query.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace ecorche::mesh {

namespace {

// What one chunk of faces found; chunks are added up in order, so the answer does not depend on
// threads.
struct Found {
  double max = -1.0;
  Vector3 place = Vector3::Zero();
  double integral = 0.0;
  double area = 0.0;

  void see(const Vector3& p, double distance) {
    if (distance > max) {
      max = distance;
      place = p;
    }
  }
};

Found overFace(const SurfaceMesh& from, Eigen::Index f, const SurfaceQuery& to, double spacing) {
  const Vector3 a = from.V.row(from.F(f, 0)).transpose();
  const Vector3 b = from.V.row(from.F(f, 1)).transpose();
  const Vector3 c = from.V.row(from.F(f, 2)).transpose();
  const double longest =
      std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  const auto n = static_cast<int>(std::clamp(std::ceil(longest / spacing), 1.0, 1000.0));

  // The face in n² equal triangles, each asked at its middle; and the three corners
  Found found;
  found.area = 0.5 * (b - a).cross(c - a).norm();
  for (const Vector3& corner : {a, b, c}) found.see(corner, to.distance(corner));
  const double share = found.area / (double(n) * n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; i + j < n; ++j) {
      for (const double third : {1.0 / 3.0, 2.0 / 3.0}) {
        if (third > 0.5 && i + j + 1 >= n) continue;  // the last in a row has no partner
        const Vector3 p = a + (i + third) / n * (b - a) + (j + third) / n * (c - a);
        const double distance = to.distance(p);
        found.see(p, distance);
        found.integral += share * distance;
      }
    }
  }
  return found;
}

/// Faces that stand in both surfaces, corner for corner: they are at no distance.
class CommonFaces {
 public:
  explicit CommonFaces(const SurfaceMesh& other) {
    faces_.reserve(static_cast<std::size_t>(other.F.rows()));
    for (Eigen::Index f = 0; f < other.F.rows(); ++f) faces_.push_back(key(other, f));
    std::ranges::sort(faces_);
  }
  [[nodiscard]] bool hold(const SurfaceMesh& mesh, Eigen::Index f) const {
    return std::ranges::binary_search(faces_, key(mesh, f));
  }

 private:
  using Key = std::array<std::array<double, 3>, 3>;
  static Key key(const SurfaceMesh& mesh, Eigen::Index f) {
    Key out;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto v = mesh.F(f, static_cast<Eigen::Index>(k));
      out[k] = {mesh.V(v, 0), mesh.V(v, 1), mesh.V(v, 2)};
    }
    std::ranges::sort(out);
    return out;
  }
  std::vector<Key> faces_;
};

Result<SurfaceDeviation::OneWay> oneWay(const SurfaceMesh& from, const SurfaceMesh& other,
                                        const SurfaceQuery& to, double spacing, RunContext& run) {
  constexpr std::int64_t kChunk = 256;
  constexpr double kAnyLength = std::numeric_limits<double>::infinity();
  const std::int64_t chunks = (from.F.rows() + kChunk - 1) / kChunk;
  std::vector<Found> found(static_cast<std::size_t>(chunks));
  const CommonFaces common(other);
  parallelFor(
      chunks,
      [&](std::int64_t chunk) {
        Found& sum = found[static_cast<std::size_t>(chunk)];
        const std::int64_t end = std::min<std::int64_t>(from.F.rows(), (chunk + 1) * kChunk);
        for (std::int64_t f = chunk * kChunk; f < end && !run.cancelled(); ++f) {
          // One point stands for a face that is in both
          const Found face = common.hold(from, f) ? overFace(from, f, to, kAnyLength)
                                                  : overFace(from, f, to, spacing);
          sum.see(face.place, face.max);
          sum.integral += face.integral;
          sum.area += face.area;
        }
      },
      1);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "comparing surfaces was interrupted");

  Found whole;
  for (const Found& part : found) {
    whole.see(part.place, part.max);
    whole.integral += part.integral;
    whole.area += part.area;
  }
  return SurfaceDeviation::OneWay{.max = std::max(whole.max, 0.0),
                                  .mean = whole.area > 0 ? whole.integral / whole.area : 0.0,
                                  .place = whole.place};
}

}  // namespace

Result<SurfaceDeviation> surfaceDeviation(const SurfaceMesh& a, const SurfaceMesh& b,
                                          double sampleSpacing, RunContext& run) {
  EC_REQUIRE(sampleSpacing > 0.0);
  const SurfaceQuery toA(a);
  const SurfaceQuery toB(b);
  if (toA.empty() || toB.empty()) {
    return fail(ErrorCode::MeshWithoutFaces, "a surface without area has no distance to another",
                {.object = toA.empty() ? a.name : b.name});
  }
  const auto there = oneWay(a, b, toB, sampleSpacing, run);
  if (!there) return passOn(there);
  const auto back = oneWay(b, a, toA, sampleSpacing, run);
  if (!back) return passOn(back);
  return SurfaceDeviation{*there, *back};
}

}  // namespace ecorche::mesh
