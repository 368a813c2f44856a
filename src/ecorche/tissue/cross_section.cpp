#include <ecorche/tissue/cross_section.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

namespace ecorche::tissue {

using mesh::Vector3;

namespace {

// A corner of a polygon inside a tet: its place and the fields there.
struct Corner {
  Vector3 p;
  Eigen::VectorXd f;
};

Corner between(const Corner& a, const Corner& b, double s) {
  return {(1.0 - s) * a.p + s * b.p, (1.0 - s) * a.f + s * b.f};
}

std::vector<Corner> clipped(const std::vector<Corner>& polygon, Eigen::Index own,
                            Eigen::Index other) {
  std::vector<Corner> out;
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    const Corner& a = polygon[k];
    const Corner& b = polygon[(k + 1) % polygon.size()];
    const double ga = a.f[own] - a.f[other];
    const double gb = b.f[own] - b.f[other];
    if (ga >= 0.0) out.push_back(a);
    if ((ga >= 0.0) != (gb >= 0.0)) out.push_back(between(a, b, ga / (ga - gb)));
  }
  return out;
}

double areaOf(const std::vector<Corner>& polygon) {
  Vector3 twice = Vector3::Zero();
  for (std::size_t k = 2; k < polygon.size(); ++k) {
    twice += (polygon[k - 1].p - polygon[0].p).cross(polygon[k].p - polygon[0].p);
  }
  return 0.5 * twice.norm();
}

}  // namespace

std::vector<double> crossSectionAreas(const mesh::TetMesh& mesh, const TissueFields& fields,
                                      TissueId tissue, const Vector3& origin,
                                      const Vector3& direction,
                                      const std::vector<double>& distances) {
  std::vector<double> areas(distances.size(), 0.0);
  const Eigen::Index own = tissue.value - 1;
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    std::array<Corner, 4> corner;
    std::array<double, 4> along{};
    bool mayOwn = false;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::int32_t v = mesh.T(t, static_cast<int>(k));
      corner[k].p = mesh.V.row(v).transpose();
      along[k] = (corner[k].p - origin).dot(direction);
      mayOwn = mayOwn || !fields.fatIsCandidate || fields.values(v, own) >= fields.values(v, 0);
    }
    if (!mayOwn) continue;
    for (std::size_t k = 0; k < 4; ++k)
      corner[k].f = fields.values.row(mesh.T(t, static_cast<int>(k))).transpose();
    const auto [low, high] = std::ranges::minmax(along);
    for (std::size_t d = 0; d < distances.size(); ++d) {
      if (!(distances[d] > low && distances[d] <= high)) continue;
      // Corners below and above the plane; a quadrangle goes round as ac, ad, bd, bc
      std::vector<std::size_t> below;
      std::vector<std::size_t> above;
      for (std::size_t k = 0; k < 4; ++k) (along[k] < distances[d] ? below : above).push_back(k);
      const auto cut = [&](std::size_t b, std::size_t a) {
        return between(corner[b], corner[a], (distances[d] - along[b]) / (along[a] - along[b]));
      };
      std::vector<Corner> polygon;
      if (below.size() == 2) {
        polygon = {cut(below[0], above[0]), cut(below[0], above[1]), cut(below[1], above[1]),
                   cut(below[1], above[0])};
      } else {
        for (const std::size_t b : below) {
          for (const std::size_t a : above) polygon.push_back(cut(b, a));
        }
      }
      for (Eigen::Index other = fields.fatIsCandidate ? 0 : 1; other < fields.values.cols();
           ++other) {
        if (other != own && !polygon.empty()) polygon = clipped(polygon, own, other);
      }
      areas[d] += areaOf(polygon);
    }
  }
  return areas;
}

}  // namespace ecorche::tissue
