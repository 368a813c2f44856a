#pragma once

#include <ecorche/studio/scene_builder.h>

#include <QApplication>
#include <QColor>
#include <QIcon>

namespace ecorche::studio {

enum class Theme { Dark, Light };

/// Colours and spacing of all widgets.
void applyTheme(QApplication& app, Theme theme);
/// Colours of the view that go with it.
[[nodiscard]] SceneColours sceneColours(Theme theme);
[[nodiscard]] QColor accentColour();

/// Icons drawn by the program, in the colour of text.
enum class Glyph {
  Select,
  Draw,
  Straight,
  Polyline,
  Mirror,
  Undo,
  Redo,
  Frame,
  Eye,
  EyeClosed,
  Lock
};
[[nodiscard]] QIcon icon(Glyph glyph, const QColor& colour);

}  // namespace ecorche::studio
