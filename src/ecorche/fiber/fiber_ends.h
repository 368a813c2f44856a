#pragma once

#include <ecorche/fiber/curve_guide.h>
#include <ecorche/fiber/fiber_field.h>
#include <ecorche/fiber/muscle_mesh.h>

#include <vector>

namespace ecorche::fiber {

enum class Role : std::uint8_t { Origin, Insertion };

/// One end of one curve: what flows in (origin) or out (insertion) through its faces, evenly by
/// area.
struct FlowEnd {
  Role role = Role::Origin;
  double flux = 0.0;                ///< of its curve, not negative [m²]
  std::vector<std::int32_t> faces;  ///< places in MuscleMesh::surface, none on unended pieces
  double area = 0.0;                ///< of these faces [m²]
};

/// Where the flow enters and leaves.
struct SelectedEnds {
  std::vector<FlowEnd> flow;           ///< origin and insertion of every curve, by turns
  std::vector<std::uint8_t> attached;  ///< #V of the muscle: 1 on faces of an end
  std::vector<FiberEnd> origins;       ///< per curve
  std::vector<FiberEnd> insertions;    ///< per curve
  std::vector<std::uint8_t> unended;   ///< per component: 1 where it lacks an end: nothing flows
  Findings findings;
};

/// Attachment faces of every curve's two ends: what lies on the end's bone (plane, tissue), no
/// farther along the curve than FiberOptions::attachmentReachRel and no farther in space than
/// attachmentRadiusRel local radii, or about one of the end's sites. A free end, or one that its
/// bone does not reach, uses the muscle's tip beyond the curve's end.
/// Ends may share faces; a face that an origin and an insertion claim goes to the nearer end.
/// @errors FiberWithoutEnds
[[nodiscard]] Result<SelectedEnds> selectEnds(const MuscleMesh& muscle, const CurveGuide& guide,
                                              const std::vector<domain::BoundaryTag>& boundaryTag,
                                              const tissue::CurveTissue& tissue,
                                              const MuscleEnds& ends, const FiberOptions& options);

}  // namespace ecorche::fiber
