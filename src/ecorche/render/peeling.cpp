#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/render/peeling.h>
#include <ecorche/render/ray_caster.h>

#include <Eigen/Geometry>
#include <algorithm>

namespace ecorche::render {

namespace {

constexpr std::int64_t kRays = 3000;

}  // namespace

std::vector<int> layersFromOutside(const VolumeItem& item, const std::vector<bool>& ignored) {
  EC_REQUIRE(item.geometry != nullptr && item.fields != nullptr);
  const auto count = static_cast<std::size_t>(item.fields->cols());
  if (!ignored.empty()) EC_REQUIRE_EQ(ignored.size(), count);
  const mesh::TetMesh& mesh = item.geometry->mesh();
  const mesh::TetBoundary& boundary = item.geometry->boundary();
  const auto faces = static_cast<std::int64_t>(boundary.tet.size());
  const std::int64_t stride = std::max<std::int64_t>(1, faces / kRays);
  const std::int64_t rays = faces / stride;

  // What each ray meets, in order
  std::vector<std::vector<std::size_t>> met(static_cast<std::size_t>(rays));
  parallelFor(
      rays,
      [&](std::int64_t r) {
        const auto f = static_cast<Eigen::Index>(r * stride);
        const mesh::Vector3 a = mesh.V.row(boundary.F(f, 0)).transpose();
        const mesh::Vector3 b = mesh.V.row(boundary.F(f, 1)).transpose();
        const mesh::Vector3 c = mesh.V.row(boundary.F(f, 2)).transpose();
        const mesh::Vector3 n = (b - a).cross(c - a);
        if (n.norm() == 0.0) return;
        // From just outside of the face: what lies beyond a gap is not under it
        const Ray ray{(a + b + c) / 3.0 + 1e-6 * item.geometry->box().diagonal() * n.normalized(),
                      -n.normalized()};
        auto& list = met[static_cast<std::size_t>(r)];
        for (const TissueSpan& span : tissuesAlong(ray, item)) {
          const auto i = static_cast<std::size_t>(span.tissue.value - 1);
          if (i == 0 || (!ignored.empty() && ignored[i])) continue;
          if (std::ranges::find(list, i) == list.end()) list.push_back(i);
        }
      },
      16);

  std::vector<std::vector<int>> depths(count);
  for (const auto& list : met)
    for (std::size_t k = 0; k < list.size(); ++k) depths[list[k]].push_back(static_cast<int>(k));
  std::vector<int> layer(count, -1);
  std::vector<int> used;
  for (std::size_t i = 0; i < count; ++i) {
    if (depths[i].empty()) continue;
    const auto quarter = depths[i].begin() + static_cast<std::ptrdiff_t>(depths[i].size() / 4);
    std::nth_element(depths[i].begin(), quarter, depths[i].end());
    layer[i] = *quarter;
    used.push_back(*quarter);
  }
  std::ranges::sort(used);
  used.erase(std::unique(used.begin(), used.end()), used.end());
  for (int& l : layer)
    if (l >= 0) l = static_cast<int>(std::ranges::lower_bound(used, l) - used.begin());
  return layer;
}

}  // namespace ecorche::render
