#pragma once

#include <ecorche/authoring/attachments.h>
#include <ecorche/authoring/snap.h>
#include <ecorche/core/finding.h>
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
      mesh::Vector3::Zero();  ///< middle of the body: of two ends, the nearer one is the origin
  std::optional<model::CutPlane> symmetry;  ///< only what lies on its kept side is built
};

/// Control points of a curve between two points: straight where nothing is in the way, else bent
/// just as far as it takes to stay inside the skin and out of closed bones. Ends are kept.
/// @param count  of control points, at least 2; up to twice as many where these do not do
[[nodiscard]] std::vector<mesh::Vector3> bentCurve(const mesh::Vector3& from,
                                                   const mesh::Vector3& to,
                                                   const Surroundings& around, int count = 4);

/// Which muscles of a table belong to the half that a symmetry plane removes: of a left and a right
/// one the one that lies lower over the plane, of the others those with their sites' middle below
/// it.
[[nodiscard]] std::vector<bool> onRemovedHalf(const std::vector<MuscleSites>& table,
                                              const model::CutPlane& symmetry, double diagonal);

/// A muscle made of a table's sites: all of them as attachments, and one curve between the two that
/// are farthest apart (an origin and an insertion, where roles are known). Sites go to the bone
/// they name if it is near, else to the nearest; curve ends lie on it. With a symmetry plane, sites
/// beyond it are left out; a muscle that goes on there ends on the plane.
/// @param findings  gets a note on every muscle that was left out and why
[[nodiscard]] std::optional<model::Tissue> muscleFrom(const MuscleSites& table,
                                                      const Surroundings& around,
                                                      Findings& findings);

}  // namespace ecorche::authoring
