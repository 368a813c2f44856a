#include <ecorche/studio/navigation.h>

#include <QObject>

namespace ecorche::studio {

std::optional<NavigationAct> navigationAct(NavigationPreset preset, Qt::MouseButton button,
                                           Qt::KeyboardModifiers modifiers, bool onModel) {
  const bool shift = modifiers.testFlag(Qt::ShiftModifier);
  const bool control = modifiers.testFlag(Qt::ControlModifier);
  const bool alt = modifiers.testFlag(Qt::AltModifier);
  if (preset == NavigationPreset::Maya && alt) {
    if (button == Qt::LeftButton) return NavigationAct::Turn;
    if (button == Qt::MiddleButton) return NavigationAct::Pan;
    if (button == Qt::RightButton) return NavigationAct::Zoom;
  }
  if (button == Qt::MiddleButton) {
    if (shift) return NavigationAct::Pan;
    return control ? NavigationAct::Zoom : NavigationAct::Turn;
  }
  if (button == Qt::RightButton) return NavigationAct::Pan;
  // Beside the model there is nothing that a tool could do: the left button turns with any preset
  if (button == Qt::LeftButton && !onModel) {
    if (preset == NavigationPreset::OneButton && shift) return NavigationAct::Pan;
    return NavigationAct::Turn;
  }
  return std::nullopt;
}

QString navigationHelp(NavigationPreset preset) {
  switch (preset) {
    case NavigationPreset::Blender:
      return QObject::tr("Middle button turns, with Shift pans, with Ctrl zooms; wheel zooms");
    case NavigationPreset::Maya:
      return QObject::tr("Alt with left turns, with middle pans, with right zooms; wheel zooms");
    case NavigationPreset::OneButton:
      return QObject::tr("Drag beside the model turns, with Shift pans; wheel zooms");
  }
  return {};
}

}  // namespace ecorche::studio
