#pragma once

#include <ecorche/fiber/curve_guide.h>
#include <ecorche/fiber/fiber_field.h>
#include <ecorche/fiber/muscle_mesh.h>

#include <algorithm>
#include <vector>

namespace ecorche::fiber {

enum class Role : std::uint8_t { None, Origin, Insertion };

/// What the flow's value is on one end of one curve: base + slope · (x − centre), within kMostTilt
/// of the base.
struct EndValues {
  Role role = Role::None;
  mesh::Vector3 centre = mesh::Vector3::Zero();  ///< of the faces [m]
  mesh::Vector3 slope = mesh::Vector3::Zero();   ///< along the faces' mean plane [1/m]

  static constexpr double kMostTilt = 0.25;
  [[nodiscard]] double at(const mesh::Vector3& x) const {
    return (role == Role::Insertion ? 1.0 : 0.0) +
           std::clamp(slope.dot(x - centre), -kMostTilt, kMostTilt);
  }
};

/// Which vertices hold the flow's values.
struct SelectedEnds {
  std::vector<EndValues> values;  ///< origin and insertion of every curve, by turns
  std::vector<std::int32_t> end;  ///< #V of the muscle: place in values, -1 where the flow is free
  [[nodiscard]] Role role(std::size_t vertex) const {
    return end[vertex] < 0 ? Role::None : values[static_cast<std::size_t>(end[vertex])].role;
  }
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
///
/// On an attachment that the curve meets at a slant the flow's values tilt: their slope along the
/// attachment is that of a flow along the curve, strong as the muscle's thickness makes it there.
/// Squarely met, they are 0 or 1.
/// @errors FiberWithoutEnds
[[nodiscard]] Result<SelectedEnds> selectEnds(const MuscleMesh& muscle, const CurveGuide& guide,
                                              const std::vector<domain::BoundaryTag>& boundaryTag,
                                              const tissue::CurveTissue& tissue,
                                              const MuscleEnds& ends, const FiberOptions& options);

}  // namespace ecorche::fiber
