#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace ecorche {

enum class Severity { Note, Repaired, Warning, Error };

[[nodiscard]] constexpr const char* name(Severity s) {
  switch (s) {
    case Severity::Note:
      return "note";
    case Severity::Repaired:
      return "repaired";
    case Severity::Warning:
      return "warning";
    case Severity::Error:
      return "error";
  }
  return "note";
}

/// Something that was seen in the input or done to it, with a point to fly to. Every repair is one.
struct Finding {
  Severity severity = Severity::Note;
  std::string kind;  ///< one lower-case word or two with a dash, stable: "hole", "duplicate-faces"
  std::string object;                    ///< mesh, bone or muscle by name
  std::string message;                   ///< a sentence for people: what, how much, what was done
  std::optional<Eigen::Vector3d> point;  ///< world [m]
  double size = 0.0;  ///< extent [m], area [m²], volume [m³] or count, as the kind says; 0: none
  /// Where something was only looked at: what `build` does about it, or what the user can.
  std::string remedy{};
};

using Findings = std::vector<Finding>;

}  // namespace ecorche
