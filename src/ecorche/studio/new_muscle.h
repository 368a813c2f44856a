#pragma once

#include <ecorche/authoring/stroke.h>
#include <ecorche/studio/session.h>

#include <optional>
#include <string>
#include <vector>

namespace ecorche::studio {

/// A name that no tissue of the project has: "muscle", "muscle 2" ….
[[nodiscard]] std::string freshName(const model::Project& project, const std::string& wanted);

/// One end of a curve that is being drawn.
struct CurveTip {
  model::Support support;
  mesh::Vector3 at = mesh::Vector3::Zero();  // [m]
};

/// The stroke while it is drawn, as far from the eye as its ends.
/// @param sights  lines of sight through its points
[[nodiscard]] std::vector<mesh::Vector3> shownPath(const std::vector<authoring::SightRay>& sights,
                                                   const mesh::Vector3& from,
                                                   const mesh::Vector3& to);

/// What draws a curve: a muscle of its own, or one more head of `tissue`.
/// @param sights     lines of sight through the points of the stroke, from tip to tip, at least two
/// @param pressures  of a pen at every point of the stroke, 0 to 1; empty: value 1 everywhere
/// @return the commands, the name of the muscle, and where its curve leaves the domain if no way
///         was found that does not
struct DrawnMuscle {
  std::vector<model::Command> commands;
  std::string name;
  std::optional<authoring::Leaving> leaving;
};
[[nodiscard]] DrawnMuscle drawnMuscle(const Session& session, const CurveTip& from,
                                      const CurveTip& to,
                                      const std::vector<authoring::SightRay>& sights,
                                      const std::vector<double>& pressures,
                                      const std::optional<std::string>& tissue);

/// Does it as one step, selects the muscle, and tells where its curve leaves the domain. False:
/// nothing was done.
bool perform(Session& session, const DrawnMuscle& drawn, const QString& label);

}  // namespace ecorche::studio
