#include <ecorche/domain/face_samples.h>

#include <algorithm>
#include <cmath>

namespace ecorche::domain {

std::vector<mesh::Vector3> faceSamples(const mesh::Positions& V, const mesh::Triangles& F,
                                       Eigen::Index f, double spacing) {
  const mesh::Vector3 a = V.row(F(f, 0)).transpose();
  const mesh::Vector3 b = V.row(F(f, 1)).transpose();
  const mesh::Vector3 c = V.row(F(f, 2)).transpose();
  const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  const int n = static_cast<int>(std::clamp(std::ceil(longest / spacing), 2.0, 12.0));
  std::vector<mesh::Vector3> out;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; i + j <= n; ++j) {
      // Corners themselves, without rounding
      if (i == n || j == n || i + j == 0) {
        out.push_back(i == n ? b : j == n ? c : a);
        continue;
      }
      out.push_back(a + (b - a) * i / n + (c - a) * j / n);
    }
  }
  return out;
}

}  // namespace ecorche::domain
