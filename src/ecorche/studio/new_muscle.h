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

/// What draws a curve: a muscle of its own, or one more head of `tissue`.
/// @param path       the stroke in space, from tip to tip [m]
/// @param pressures  of a pen at every point of the path, 0 to 1; empty: value 1 everywhere
/// @return the commands, and the name of the muscle
struct DrawnMuscle {
  std::vector<model::Command> commands;
  std::string name;
};
[[nodiscard]] DrawnMuscle drawnMuscle(const Session& session, const CurveTip& from,
                                      const CurveTip& to, const std::vector<mesh::Vector3>& path,
                                      const std::vector<double>& pressures,
                                      const std::optional<std::string>& tissue);

}  // namespace ecorche::studio
