#pragma once

#include <ecorche/authoring/snap.h>
#include <ecorche/mesh/surface_query.h>
#include <ecorche/mesh/types.h>

#include <vector>

namespace ecorche::authoring {

/// A line of sight.
struct SightRay {
  mesh::Vector3 origin = mesh::Vector3::Zero();      // [m]
  mesh::Vector3 direction = mesh::Vector3::UnitY();  // unit
};

/// What a stroke has to mind.
struct StrokeRoom {
  const mesh::SurfaceQuery* skin = nullptr;  ///< closed; null: nothing is known of it
  const std::vector<BoneSurface>& bones;
  std::vector<model::CutPlane> planes;  ///< the stroke stays in the half that each keeps
  double diagonal = 0.0;                ///< of the body [m]
};

/// A stroke drawn over the picture, in depth: every point lies on its own line of sight, and its
/// distance from the eye goes linearly from that of the first point to that of the last, along the
/// stroke [ABLSJ21 §3.2].
///
/// @param sights  lines of sight through the points of the stroke, at least two
/// @param from    where the stroke begins, on its first line of sight [m]
/// @param to      where it ends, on its last [m]
/// @return  a point for each line of sight; the first and last are `from` and `to`
[[nodiscard]] std::vector<mesh::Vector3> strokeInDepth(const std::vector<SightRay>& sights,
                                                       const mesh::Vector3& from,
                                                       const mesh::Vector3& to);

/// How muscles lie between bone and skin (docs/algorithms/first_guess.md tells how these were
/// found). Lengths are shares of the stroke's length [unitless].
struct DepthHabits {
  /// How firmly a muscle keeps to its depth under the skin, which goes evenly from that of one end
  /// to that of the other. 0: not at all.
  double skinWeight = 12.0;
  /// Room that its middle wants from bones and from skin, and how much a lack of it counts.
  double fromBone = 0.015;
  double fromSkin = 0.02;
  double roomWeight = 0.17;
  /// How far a muscle that nothing holds leans from the linear depth towards the eye, in its
  /// middle: whoever draws looks from the side where it lies.
  double lean = 0.02;
};

/// The same with a better guess of the depth, the least of
///   Σ (change of depth − linear change)² + (depth under the skin less that expected)²
///   + (lack of room from bones and skin)² − lean,
/// searched over all depths at once, so that it finds the better side of a bone.
///
/// @param sights  as above, with what is in the way. Without bones, skin and lean: linear
/// @return  a point for each of at most 33 lines of sight along the stroke, ends as given. The same
///          on any number of threads; moved, turned and scaled with everything
[[nodiscard]] std::vector<mesh::Vector3> strokeInFlesh(const std::vector<SightRay>& sights,
                                                       const mesh::Vector3& from,
                                                       const mesh::Vector3& to,
                                                       const StrokeRoom& room,
                                                       const DepthHabits& habits = {});

}  // namespace ecorche::authoring
