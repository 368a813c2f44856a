#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/render/scene.h>
#include <ecorche/render/tissue_image.h>
#include <ecorche/render/volume_item.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace ecorche::render {

/// The first point along a ray that belongs to a visible tissue.
struct VolumeHit {
  enum class Where : std::uint8_t {
    Interface,  ///< another tissue, one that is not seen, lies before it
    Boundary,   ///< the domain begins there
    Cut         ///< the clip plane opens it there
  };
  TissueId tissue;
  Where where = Where::Interface;
  mesh::Vector3 at = mesh::Vector3::Zero();       ///< place in the anatomy, not shifted [m]
  mesh::Vector3 normal = mesh::Vector3::UnitX();  ///< unit, as it is shaded
  std::int32_t tet = -1;
  double distance = 0.0;  ///< from the ray's beginning [m]
};

/// Casts a ray through the tets, without OpenGL: what the renderer is measured against, and how
/// things are picked.
///
/// Walks from tet to tet; no ray slips through between two of them. Where the ray is in a tet,
/// every field is linear along it, so the owner at the way in and every change of owner is solved.
/// Tissues whose opacity is below 1 are hit only where no opaque one is.
///
/// @param clip  what its normal points at is kept; where it cuts a tissue that is visible or
/// `inCut`, that is hit
/// @return  nothing where no visible tissue lies on the ray
///
/// Costs a fraction of a millisecond on 640 k tets and 40 fields.
[[nodiscard]] std::optional<VolumeHit> castRay(const Ray& ray, const VolumeItem& item,
                                               const std::optional<ClipPlane>& clip = {});

/// A ray for every pixel's middle, on all threads; opaque tissues only.
[[nodiscard]] TissueImage castImage(const Camera& camera, int width, int height,
                                    const VolumeItem& item,
                                    const std::optional<ClipPlane>& clip = {});

/// A piece of a ray inside one tissue.
struct TissueSpan {
  TissueId tissue;
  double enter = 0.0;  ///< [m] from the ray's beginning
  double leave = 0.0;  ///< [m]
};
/// Everything a ray passes through, visible or not, front to back; neighbouring pieces of one
/// tissue are one.
[[nodiscard]] std::vector<TissueSpan> tissuesAlong(const Ray& ray, const VolumeItem& item,
                                                   const std::optional<ClipPlane>& clip = {});

}  // namespace ecorche::render
