#pragma once

#include <ecorche/authoring/attachments.h>
#include <ecorche/authoring/snap.h>
#include <ecorche/authoring/twins.h>
#include <ecorche/core/finding.h>
#include <ecorche/core/run_context.h>
#include <ecorche/mesh/surface_query.h>

#include <optional>
#include <vector>

namespace ecorche::authoring {

/// What a first curve has to mind.
struct Surroundings {
  const mesh::SurfaceQuery& skin;  ///< closed
  const std::vector<BoneSurface>& bones;
  double diagonal = 0.0;  ///< of the skin [m]
  mesh::Vector3 centre =
      mesh::Vector3::Zero();     ///< middle of the body: of two ends, the nearer one is the origin
  std::optional<Mirror> mirror;  ///< what makes left and right alike; its first side is kept
  bool keepsBothSides =
      false;  ///< else what lies beyond the mirror is cut off; `plane` is its name
  std::string plane = "median";
};

/// Control points of a curve between two points: straight where nothing is in the way, else bent
/// gently, just as far as it takes to stay inside the skin and out of bones. Ends are kept. Four
/// points where they do, up to twenty.
[[nodiscard]] std::vector<mesh::Vector3> bentCurve(const mesh::Vector3& from,
                                                   const mesh::Vector3& to,
                                                   const Surroundings& around);

struct FirstMuscles {
  std::vector<model::Tissue> muscles;  ///< in table order, without those that could not be made
  Findings
      findings;  ///< a note on every muscle that was left out and why, warnings about poor ones
};

/// Muscles made of a table's sites: all sites as attachments, and curves between those that
/// planHeads chooses, with ends on bones where these are exposed, clear of skin and bones and apart
/// from one another.
///
/// With a mirror, twins are made alike: one is made, the other is its image with its own bones. If
/// only the first side is kept, sites beyond the plane are left out, and a muscle that goes on
/// there ends on the plane; else it goes through.
///
/// @errors  Cancelled
[[nodiscard]] Result<FirstMuscles> firstMuscles(const std::vector<MuscleSites>& table,
                                                const Surroundings& around, RunContext& run);

/// How well a curve is placed: shares of its length outside the skin, and within closed bones,
/// deeper than the tolerance of ends (a two-thousandth of the diagonal).
struct Placement {
  double outside = 0.0;
  double inBone = 0.0;
};
[[nodiscard]] Placement placementOf(const mesh::Spline& curve, const Surroundings& around);

}  // namespace ecorche::authoring
