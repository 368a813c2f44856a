#include <ecorche/core/contract.h>
#include <ecorche/render/tissue_image.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace ecorche::render {

Agreement agreement(const TissueImage& a, const TissueImage& b) {
  EC_REQUIRE_EQ(a.width, b.width);
  EC_REQUIRE_EQ(a.height, b.height);
  Agreement out;
  std::size_t same = 0;
  std::size_t sameSeen = 0;
  std::vector<double> angle;
  for (std::size_t i = 0; i < a.tissue.size(); ++i) {
    const bool equal = a.tissue[i] == b.tissue[i];
    same += equal ? 1 : 0;
    if (a.tissue[i] == kNoTissue && b.tissue[i] == kNoTissue) continue;
    ++out.pixels;
    if (!equal) continue;
    ++sameSeen;
    const Eigen::Vector3d n = a.normal[i].cast<double>();
    const Eigen::Vector3d m = b.normal[i].cast<double>();
    angle.push_back(std::atan2(n.cross(m).norm(), n.dot(m)) * 180.0 / std::numbers::pi);
  }
  const auto share = [](std::size_t part, std::size_t whole) {
    return whole == 0 ? 1.0 : static_cast<double>(part) / static_cast<double>(whole);
  };
  out.sameTissue = share(same, a.tissue.size());
  out.sameSeen = share(sameSeen, out.pixels);
  out.normalsClose = share(
      static_cast<std::size_t>(std::ranges::count_if(angle, [](double x) { return x <= 3.0; })),
      angle.size());
  if (!angle.empty()) {
    const std::size_t at = (angle.size() - 1) * 95 / 100;
    std::nth_element(angle.begin(), angle.begin() + static_cast<std::ptrdiff_t>(at), angle.end());
    out.normalP95Deg = angle[at];
  }
  return out;
}

}  // namespace ecorche::render
