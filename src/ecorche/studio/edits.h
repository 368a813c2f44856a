#pragma once

#include <ecorche/studio/session.h>
#include <ecorche/studio/twins.h>

#include <QString>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::studio {

// What menus, keys and panels do to what is selected, as commands. An empty list: nothing to do.

struct Edit {
  std::vector<model::Command> commands;
  QString label;
  Selection select;  ///< afterwards
};

/// Control point, curve or muscle: the smallest that is selected. A curve keeps two points.
[[nodiscard]] Edit removeSelected(const Session& session);
/// A control point on the selected curve where it passes nearest to a place; the curve keeps its
/// shape as well as a spline can.
[[nodiscard]] Edit insertPoint(const Session& session, const mesh::Vector3& near);
/// The selected curve becomes two heads that meet in the selected point, which is not an end.
[[nodiscard]] Edit splitCurve(const Session& session);
/// The selected muscle once more, under a new name.
[[nodiscard]] Edit duplicate(const Session& session);
/// Protects the selected muscle, or lifts that.
[[nodiscard]] Edit protectSelected(const Session& session, bool on);
/// Keeps the selected muscle's twin in step from now on, or lets it go.
[[nodiscard]] Edit keepTwinOfSelected(const Session& session, bool on);
/// All values of the selected muscle times a factor.
[[nodiscard]] Edit thicken(const Session& session, double factor);

/// The selected muscle's image on the other side, with the bones of that side and its name; a name
/// without a side gets one. Where the image exists it is brought in step.
/// Ends come to lie on the bone of that side, if one is near.
[[nodiscard]] Edit mirrored(const Session& session, const MirrorPlane& plane);

}  // namespace ecorche::studio
