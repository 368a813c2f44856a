#pragma once

#include <ecorche/authoring/attachments.h>
#include <ecorche/authoring/free_space.h>
#include <ecorche/authoring/twins.h>

#include <string>
#include <vector>

namespace ecorche::authoring {

/// Where an end of a curve sits.
struct Seat {
  mesh::Vector3 at = mesh::Vector3::Zero();
  model::Support support;
  int bone = -1;        ///< its place in the list of bones; -1: on none
  bool exposed = true;  ///< neither in another bone nor at or beyond the skin
};

/// The bone that the site names where it is near enough, else the nearest one, else free. A place
/// that another bone or the skin covers is moved along the bone to the nearest one that is not.
/// @param diagonal  of the body [m]
[[nodiscard]] Seat seatOf(const AttachmentSite& site, const std::vector<BoneSurface>& bones,
                          const FreeSpace& space, double diagonal);

/// A seat on a plane as near to p as walls allow.
[[nodiscard]] Seat seatOnPlane(const mesh::Vector3& p, const Mirror& plane, const std::string& name,
                               const FreeSpace& space, double diagonal);

/// The seat moved to the point of its bone nearest to p; stays where that point is covered.
[[nodiscard]] Seat slid(const Seat& seat, const mesh::Vector3& p,
                        const std::vector<BoneSurface>& bones, const FreeSpace& space,
                        double diagonal);

/// An end that may slide.
struct SlidingEnd {
  Seat* seat = nullptr;
  int muscle = 0;      ///< ends of one muscle may meet
  double apart = 0.0;  ///< from ends of others on the same bone [m]
  /// Plane from which the end keeps half of `apart`; a zero normal: none.
  mesh::Vector3 planePoint = mesh::Vector3::Zero();
  mesh::Vector3 planeNormal = mesh::Vector3::Zero();
};

/// Slides ends that crowd on one bone apart along its surface.
void spreadEnds(std::vector<SlidingEnd>& ends, const std::vector<BoneSurface>& bones,
                const FreeSpace& space, double diagonal);

}  // namespace ecorche::authoring
