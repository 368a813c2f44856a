#pragma once

#include <ecorche/authoring/free_space.h>
#include <ecorche/mesh/types.h>

#include <vector>

namespace ecorche::authoring {

/// A curve on its way to a good place: points at equal steps from end to end, which stay.
struct Band {
  std::vector<mesh::Vector3> points;
  /// What it follows where nothing is in the way, at the same steps; empty: a straight line.
  std::vector<mesh::Vector3> guide;
  /// How far it keeps from bone and skin away from its ends [m].
  double clearance = 0.0;
  /// How far it keeps from bands of other muscles away from its ends [m].
  double apart = 0.0;
  int muscle = 0;  ///< bands of one muscle may meet
  /// Half space that the band stays in: (x − point)·normal ≥ 0. A zero normal: everywhere.
  mesh::Vector3 planePoint = mesh::Vector3::Zero();
  mesh::Vector3 planeNormal = mesh::Vector3::Zero();
};

/// A band between two ends; `along` are places that it passes.
/// @param diagonal  of the body [m]
[[nodiscard]] Band bandThrough(const mesh::Vector3& from, const std::vector<mesh::Vector3>& along,
                               const mesh::Vector3& to, double diagonal);

/// Share of its clearance that a curve keeps at so far from its nearer end: it has to come from a
/// bone.
[[nodiscard]] double easeNearEnd(double fromEnd, double clearance);

/// Bends a band like a thin beam, just as far as it takes to keep clear of walls; where that does
/// not end well, detours to eight sides are tried and the best is taken.
/// @return  how much clearance is still missing at the worst point, over the clearance
double settle(Band& band, const FreeSpace& space);

/// The same without detours: for a band that is nearly there.
double settleNearby(Band& band, const FreeSpace& space);

/// All bands at once, so that they also keep apart from one another. The same for any thread count.
/// @param mirrored  bands have images beyond this plane (point, unit normal), which they keep apart
///                  from too; a zero normal: none
void settleTogether(std::vector<Band>& bands, const FreeSpace& space,
                    const mesh::Vector3& mirrorPoint, const mesh::Vector3& mirrorNormal);

/// Control points of a spline along the band: four where they do, more where the spline would come
/// nearer to a wall than half the clearance or stray from the band by more than that, up to twenty.
[[nodiscard]] std::vector<mesh::Vector3> controlPoints(const Band& band, const FreeSpace& space);

}  // namespace ecorche::authoring
