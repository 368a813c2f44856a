#pragma once

#include <QString>
#include <Qt>
#include <optional>
#include <string_view>

namespace ecorche::studio {

/// Which hands move the eye, as people know it from other programs.
enum class NavigationPreset {
  Blender,   ///< middle: turn, with Shift: pan, with Ctrl: zoom
  Maya,      ///< Alt with left: turn, with middle: pan, with right: zoom
  OneButton  ///< left beside the model: turn, with Shift: pan; for pens and touch pads
};
enum class NavigationAct { Turn, Pan, Zoom };

/// What a pressed button does to the eye; nothing: it belongs to the tool. With any preset the
/// middle button turns and the right one pans.
/// @param onModel  the tool has something under the hand
[[nodiscard]] std::optional<NavigationAct> navigationAct(NavigationPreset preset,
                                                         Qt::MouseButton button,
                                                         Qt::KeyboardModifiers modifiers,
                                                         bool onModel);

[[nodiscard]] QString navigationHelp(NavigationPreset preset);

}  // namespace ecorche::studio
