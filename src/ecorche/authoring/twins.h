#pragma once

#include <ecorche/authoring/attachments.h>
#include <ecorche/core/finding.h>

#include <optional>
#include <vector>

namespace ecorche::authoring {

/// A plane that mirrors the body, as left and right see it.
struct Mirror {
  mesh::Vector3 point = mesh::Vector3::Zero();    // [m]
  mesh::Vector3 normal = mesh::Vector3::UnitY();  // unit; its side is called the first one

  [[nodiscard]] double height(const mesh::Vector3& p) const { return (p - point).dot(normal); }
  [[nodiscard]] mesh::Vector3 image(const mesh::Vector3& p) const {
    return p - 2.0 * height(p) * normal;
  }
};

/// Place of every muscle's twin in the table: the one whose name differs in the side alone.
[[nodiscard]] std::vector<std::optional<std::size_t>> twinsIn(
    const std::vector<MuscleSites>& table);

/// The table with what one of two twins lacks taken from the other: sites whose image is not near
/// any site of the twin are added to it, without their patch.
/// @param diagonal  of the body [m]
/// @param findings  a note for each muscle that was given sites
[[nodiscard]] std::vector<MuscleSites> withTwinSites(const std::vector<MuscleSites>& table,
                                                     const Mirror& mirror, double diagonal,
                                                     Findings& findings);

/// Which muscles lie on the mirror's second side: of twins the one that lies lower over the plane,
/// of the others those with their sites' middle below it.
[[nodiscard]] std::vector<bool> onSecondSide(const std::vector<MuscleSites>& table,
                                             const Mirror& mirror, double diagonal);

/// Sites of a muscle that lies on both sides of the plane, as the first side sees them: those
/// beyond the plane are mirrored, and left out where their image is there already.
struct FoldedSites {
  std::vector<AttachmentSite> sites;
  /// One that was beyond the plane, as the table has it; none where all were on the first side.
  std::optional<AttachmentSite> beyond;
};
[[nodiscard]] FoldedSites folded(const MuscleSites& muscle, const Mirror& mirror, double diagonal);

}  // namespace ecorche::authoring
