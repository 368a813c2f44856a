#pragma once

#include <ecorche/fiber/curve_guide.h>
#include <ecorche/fiber/fiber_field.h>
#include <ecorche/fiber/muscle_mesh.h>

#include <vector>

namespace ecorche::fiber {

enum class Role : std::uint8_t { None, Origin, Insertion };

/// Which vertices hold the flow's two values.
struct SelectedEnds {
  std::vector<Role> role;            ///< #V of the muscle
  std::vector<FiberEnd> origins;     ///< per curve
  std::vector<FiberEnd> insertions;  ///< per curve
  std::vector<std::uint8_t>
      speck;  ///< per component: 1 where it lacks an end and is too small to matter
  Findings findings;
};

/// Attachment faces of every curve's two ends: what lies on the end's bone (plane, tissue), no
/// farther along the curve than FiberOptions::attachmentReachRel and no farther in space than
/// attachmentRadiusRel local radii, or about one of the end's sites. A free end, or one that its
/// bone does not reach, uses the muscle's tip beyond the curve's end.
/// @errors FiberWithoutEnds
[[nodiscard]] Result<SelectedEnds> selectEnds(const MuscleMesh& muscle, const CurveGuide& guide,
                                              const std::vector<domain::BoundaryTag>& boundaryTag,
                                              const tissue::CurveTissue& tissue,
                                              const MuscleEnds& ends, const FiberOptions& options);

}  // namespace ecorche::fiber
