#include <ecorche/core/parallel.h>
#include <ecorche/domain/tight_places.h>
#include <ecorche/domain/triangle_tree.h>

#include <Eigen/Geometry>

namespace ecorche::domain {

using mesh::Vector3;

TightPlaces::TightPlaces(std::function<double(const Vector3&)> reach)
    : reach_(std::move(reach)), thinned_(1 << 10), points_(1 << 10) {}

void TightPlaces::add(const Vector3& p) {
  constexpr double kThinned = 0.25;
  const double reach = reach_(p);
  if (thinned_.taken(p, kThinned * reach)) return;
  thinned_.add(p, kThinned * reach);
  points_.add(p, reach);
}

bool TightPlaces::contains(const Vector3& p) const { return points_.taken(p, reach_(p)); }

std::vector<Vector3> placesInGaps(const TaggedSurface& walls, double gap) {
  const TriangleTree tree(walls.V, walls.F);
  std::vector<std::uint8_t> tight(static_cast<std::size_t>(walls.F.rows()), 0);
  std::vector<Vector3> middle(tight.size());
  parallelFor(
      walls.F.rows(),
      [&](std::int64_t f) {
        const Vector3 a = walls.V.row(walls.F(f, 0)).transpose();
        const Vector3 b = walls.V.row(walls.F(f, 1)).transpose();
        const Vector3 c = walls.V.row(walls.F(f, 2)).transpose();
        const Vector3 n = (b - a).cross(c - a).normalized();
        const auto at = static_cast<std::size_t>(f);
        middle[at] = (a + b + c) / 3.0;
        if (n.norm() < 0.5) return;
        for (const Vector3& direction : {n, Vector3(-n)}) {
          // Off the face itself, which the ray starts on
          if (tree.firstHit(middle[at], direction, 1e-6 * gap, gap)) tight[at] = 1;
        }
      },
      256);
  std::vector<Vector3> out;
  for (std::size_t f = 0; f < tight.size(); ++f) {
    if (tight[f] != 0) out.push_back(middle[f]);
  }
  return out;
}

}  // namespace ecorche::domain
