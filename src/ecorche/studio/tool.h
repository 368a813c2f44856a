#pragma once

#include <ecorche/studio/orbit_camera.h>
#include <ecorche/studio/pick.h>
#include <ecorche/studio/session.h>

#include <QObject>
#include <QString>
#include <optional>
#include <vector>

namespace ecorche::studio {

/// What a hand did over the view.
struct Touch {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< from the top left
  Qt::KeyboardModifiers modifiers;
  std::optional<double> pressure;  ///< of a pen, 0 to 1; nothing for a mouse
};

/// What a tool shows over the model.
struct Overlay {
  Selection hovered;
  std::vector<mesh::Vector3> stroke;
  std::vector<mesh::Vector3> marks;
  Qt::CursorShape cursor = Qt::ArrowCursor;
};

/// What the hand does in the view: one at a time. Each tool has a file of its own; it looks at the
/// session and proposes commands.
class Tool : public QObject {
  Q_OBJECT

 public:
  struct View {
    Session& session;
    const OrbitCamera& camera;
  };
  explicit Tool(View view) : view_(view) {}

  virtual void hover(const Touch&) {}
  /// False: nothing here for this tool, the view may turn instead.
  virtual bool press(const Touch&) { return false; }
  virtual void drag(const Touch&) {}
  virtual void release(const Touch&) {}
  virtual void doubleClick(const Touch&) {}
  /// Gives up what is under way; false: there was nothing.
  virtual bool cancel() { return false; }
  /// Ends what takes several clicks.
  virtual void finish() {}

  /// What the hand can do now, in a sentence.
  [[nodiscard]] virtual QString hint() const = 0;
  [[nodiscard]] const Overlay& overlay() const { return overlay_; }

 signals:
  void overlayChanged();
  void hintChanged();

 protected:
  View view_;
  Overlay overlay_;

  [[nodiscard]] Session& session() const { return view_.session; }
  [[nodiscard]] Picker::Input pickInput() const;
  void show(const Overlay& overlay);
};

}  // namespace ecorche::studio
