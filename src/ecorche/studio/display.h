#pragma once

#include <ecorche/render/palette.h>
#include <ecorche/render/scene.h>

#include <optional>
#include <set>
#include <string>

namespace ecorche::studio {

/// What a user chose to look at. Not part of the project: nothing here is undone or saved with it.
struct Display {
  bool skin = true;
  double skinOpacity = 0.35;  ///< 0: not drawn, 1: as opaque as skin gets [unitless]
  bool bones = true;
  bool muscles = true;
  bool fibers = false;     ///< streaks along the fibres
  bool spread = false;     ///< handles for the selected muscle's spread across its curve
  bool allCurves = false;  ///< of every muscle; those of the selected one are always there
  bool fine = true;        ///< soft light and shadows while nothing moves
  render::Palette palette = render::Palette::Anatomical;
  std::optional<render::ClipPlane> clip;  ///< what its normal points at stays
  std::optional<int> peelAbove;           ///< muscles of higher layers are hidden
  std::set<std::string> hidden;           ///< tissues and bones by name
  std::optional<std::string> solo;        ///< this tissue alone
  std::optional<std::string> xray;        ///< this tissue through all others
  double explode = 0.0;                   ///< how far muscles are drawn apart, 0 to 1 [unitless]

  [[nodiscard]] bool showsTissue(const std::string& name) const {
    return muscles && (solo ? *solo == name : !hidden.contains(name));
  }
  [[nodiscard]] bool showsBone(const std::string& name) const {
    return bones && !hidden.contains(name);
  }
};

/// What is being worked on. Empty names and -1: nothing.
struct Selection {
  std::string tissue;
  int curve = -1;
  int point = -1;
  std::string bone;
  bool operator==(const Selection&) const = default;
};

}  // namespace ecorche::studio
