#pragma once

#include <ecorche/core/ids.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace ecorche::render {

/// What tissue is seen at every pixel, row by row from the top left.
struct TissueImage {
  int width = 0;
  int height = 0;
  std::vector<TissueId> tissue;         ///< kNoTissue where none is seen
  std::vector<Eigen::Vector3f> normal;  ///< of its surface, unit; zero where none is seen

  TissueImage() = default;
  TissueImage(int w, int h)
      : width(w),
        height(h),
        tissue(static_cast<std::size_t>(w) * static_cast<std::size_t>(h), kNoTissue),
        normal(tissue.size(), Eigen::Vector3f::Zero()) {}

  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x);
  }
};

/// How far two pictures of the same size say the same.
struct Agreement {
  std::size_t pixels = 0;     ///< where either shows a tissue
  double sameTissue = 1.0;    ///< share of all pixels of the picture
  double sameSeen = 1.0;      ///< share of `pixels`: the stricter figure
  double normalsClose = 1.0;  ///< share of pixels with the same tissue whose normals are within 3°
  double normalP95Deg = 0.0;  ///< 95 % of the normals are within this [degrees]
};
[[nodiscard]] Agreement agreement(const TissueImage& a, const TissueImage& b);

}  // namespace ecorche::render
