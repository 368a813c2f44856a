#pragma once

#include <ecorche/mesh/self_intersection.h>

#include <cstdint>
#include <span>

namespace ecorche::domain {

/// A face after a step of resampling, with the corners that it will have.
struct NewFace {
  std::int32_t face = 0;
  mesh::FaceCorners corners;
};

/// What a step of resampling takes away and what it lays instead. Faces may stand in both lists.
struct SurfaceStep {
  std::span<const std::int32_t> before;
  std::span<const NewFace> after;
};

}  // namespace ecorche::domain
