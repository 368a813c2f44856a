#pragma once

#include <ecorche/model/project_file.h>
#include <ecorche/studio/main_window.h>
#include <ecorche/studio/theme.h>

#include <QApplication>
#include <QDir>
#include <QElapsedTimer>
#include <QMouseEvent>
#include <QPixmap>
#include <QScreen>
#include <QStandardPaths>
#include <QSurfaceFormat>
#include <QTest>
#include <catch2/catch.hpp>
#include <functional>
#include <string>

#include "support/paths.h"
#include "support/patience.h"

namespace ecorche::test {

/// The one application of a test program, as ecorche-studio sets it up, with settings of its own.
inline QApplication& application() {
  static int argc = 1;
  static char name[] = "test_studio";
  static char* argv[] = {name, nullptr};
  static TempFolder settings;
  static QApplication* app = [] {
    setenv("XDG_CONFIG_HOME", settings.path().c_str(), 1);
    QSurfaceFormat format;
    format.setVersion(3, 3);
    format.setProfile(QSurfaceFormat::CoreProfile);
    QSurfaceFormat::setDefaultFormat(format);
    auto* made = new QApplication(argc, argv);  // lives until the process ends
    QApplication::setOrganizationName("ecorche");
    QApplication::setApplicationName("test");
    studio::applyTheme(*made, studio::Theme::Dark);
    return made;
  }();
  return *app;
}

/// Handles events until it is so. @return whether it became so in time
inline bool waitFor(const std::function<bool()>& so, int seconds = 60) {
  QElapsedTimer clock;
  clock.start();
  while (!so()) {
    if (clock.elapsed() > 1000 * seconds * kPatience) return false;
    QTest::qWait(10);
  }
  return true;
}

/// A hand over the view, and an eye that keeps what it saw.
class Hand {
 public:
  explicit Hand(studio::MainWindow& window) : window_(window) {}

  [[nodiscard]] static QPoint pointOf(const Eigen::Vector2d& pixel) {
    return {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))};
  }
  void drag(const std::vector<QPoint>& path, Qt::KeyboardModifiers modifiers = Qt::NoModifier,
            Qt::MouseButton button = Qt::LeftButton) {
    studio::Viewport& view = window_.view();
    QTest::mouseMove(&view, path.front());
    QTest::mousePress(&view, button, modifiers, path.front());
    for (std::size_t i = 1; i < path.size(); ++i) {
      for (int k = 1; k <= 8; ++k) {
        const QPoint at = path[i - 1] + (path[i] - path[i - 1]) * k / 8;
        // QTest::mouseMove has no buttons
        QMouseEvent move(QEvent::MouseMove, at, view.mapToGlobal(at), Qt::NoButton, button,
                         modifiers);
        QApplication::sendEvent(&view, &move);
        QTest::qWait(1);
      }
    }
    QTest::mouseRelease(&view, button, modifiers, path.back());
  }
  void click(const QPoint& at) { QTest::mouseClick(&window_.view(), Qt::LeftButton, {}, at); }
  void key(Qt::Key key, Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    // Keys go to the active window, and a screen without a window manager makes none active
    if (QApplication::activeWindow() != &window_) QApplication::setActiveWindow(&window_);
    QTest::keyClick(&window_, key, modifiers);
  }
  [[nodiscard]] bool settle(int seconds = 120) {
    return waitFor([&] { return window_.session().isSettled(); }, seconds);
  }
  /// The view at rest, every pass made.
  [[nodiscard]] QImage look() {
    window_.view().redraw();
    REQUIRE(waitFor([&] { return window_.view().isFinished(); }));
    return window_.view().grabFramebuffer();
  }
  /// The whole window, kept in ECORCHE_SHOTS where that is set.
  void keep(const std::string& step) {
    const char* folder = std::getenv("ECORCHE_SHOTS");
    if (folder == nullptr) return;
    QTest::qWait(20);
    if (window_.session().isOpen()) (void)look();
    const QImage whole = window_.screen()->grabWindow(window_.winId()).toImage();
    REQUIRE(!whole.isNull());
    QDir().mkpath(folder);
    REQUIRE(whole.save(QString("%1/%2.png").arg(folder, QString::fromStdString(step))));
  }

 private:
  studio::MainWindow& window_;
};

/// Share of pixels that differ visibly between two pictures of one size.
inline double changedShare(const QImage& a, const QImage& b) {
  REQUIRE(a.size() == b.size());
  int changed = 0;
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      const QColor p = a.pixelColor(x, y);
      const QColor q = b.pixelColor(x, y);
      changed += std::abs(p.red() - q.red()) + std::abs(p.green() - q.green()) +
                     std::abs(p.blue() - q.blue()) >
                 24;
    }
  }
  return static_cast<double>(changed) / (a.width() * a.height());
}

/// The example that ships with the code.
inline model::Project arm() {
  const auto file = std::filesystem::path(ECORCHE_SOURCE_DIR) / "examples/arm/arm.ecorche";
  return model::loadProject(file).value();
}

}  // namespace ecorche::test
