#pragma once

#include <ecorche/render/renderer.h>
#include <ecorche/studio/navigation.h>
#include <ecorche/studio/orbit_camera.h>
#include <ecorche/studio/scene_builder.h>
#include <ecorche/studio/session.h>
#include <ecorche/studio/tool.h>

#include <QOpenGLWidget>
#include <QTimer>
#include <memory>
#include <optional>

class QOpenGLFramebufferObject;

namespace ecorche::studio {

/// The view of the model: draws what the session shows, turns the eye, hands the rest to the tool.
///
/// While anything moves a picture is one quick pass, of fewer pixels where the machine is too slow
/// for all of them; at rest passes are added until light is soft
/// and edges are smooth. Where OpenGL 3.3 is missing it says so in place of the picture.
class Viewport : public QOpenGLWidget {
  Q_OBJECT

 public:
  explicit Viewport(Session& session, QWidget* parent = nullptr);
  ~Viewport() override;

  /// Why this machine can show no picture; empty where it can. Asked before the first view is
  /// shown.
  [[nodiscard]] static QString troubleOfMachine();

  [[nodiscard]] Tool::View toolView() { return {session_, camera_}; }
  void setTool(Tool* tool);  ///< not owned
  [[nodiscard]] const OrbitCamera& eye() const { return camera_; }
  void setNavigation(NavigationPreset preset) { navigation_ = preset; }
  void setColours(const SceneColours& colours);

  void frameAll();
  void frameSelected();  ///< all, where nothing is selected
  void lookFrom(double azimuthDeg, double elevationDeg);
  void setParallel(bool parallel);
  /// Brings a place to the middle, near enough to see it.
  void flyTo(const mesh::Vector3& place);

  [[nodiscard]] SceneBuilder& scenes() { return scenes_; }
  /// Every pass that it wants has been made.
  [[nodiscard]] bool isFinished() const { return finished_; }

 public slots:
  void redraw();  ///< something has changed

 signals:
  void drawn();
  void troubled(const QString& why);

 protected:
  void initializeGL() override;
  void resizeGL(int width, int height) override;
  void paintGL() override;
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void tabletEvent(QTabletEvent* event) override;
  void leaveEvent(QEvent* event) override;

 private:
  Session& session_;
  OrbitCamera camera_;
  SceneBuilder scenes_;
  SceneColours colours_;
  Tool* tool_ = nullptr;
  NavigationPreset navigation_ = NavigationPreset::Blender;

  std::optional<render::Renderer> renderer_;
  std::unique_ptr<QOpenGLFramebufferObject> coarse_;
  QString trouble_;
  bool dirty_ = true;
  bool finished_ = false;
  bool quickPicture_ = true;
  bool sharp_ = false;  // a quick picture at rest: every pixel
  int divisor_ = 1;     // of the window's pixels, for pictures in motion
  int framed_ = 0;      // for: 1 meshes, 2 their domain
  QTimer rest_;         // nothing has moved for a moment

  std::optional<NavigationAct> navigating_;
  bool toolHolds_ = false;
  Eigen::Vector2d last_ = Eigen::Vector2d::Zero();

  void begin(bool quick);
  void showCoarse();
  void adaptDivisor(double seconds);
  [[nodiscard]] int divisorNow() const { return quickPicture_ && !sharp_ ? divisor_ : 1; }
  void navigate(const Eigen::Vector2d& pixel);
  void frameWhenFirstSeen();
  [[nodiscard]] mesh::Box shownBox() const;
  [[nodiscard]] static Touch touchOf(const QMouseEvent& event);
  void pressed(Qt::MouseButton button, const Touch& touch);
  void moved(const Touch& touch, bool down);
  void released(const Touch& touch);
};

}  // namespace ecorche::studio
