#pragma once

#include <ecorche/authoring/new_project.h>
#include <ecorche/studio/background.h>
#include <ecorche/studio/click_tool.h>
#include <ecorche/studio/draw_tool.h>
#include <ecorche/studio/edits.h>
#include <ecorche/studio/select_tool.h>
#include <ecorche/studio/session.h>
#include <ecorche/studio/theme.h>
#include <ecorche/studio/viewport.h>

#include <QMainWindow>
#include <memory>

class QDockWidget;
class QLabel;
class QProgressBar;
class QStackedWidget;
class QToolButton;

namespace ecorche::studio {

class NewDialog;
class StartPage;

/// The window: view in the middle, panels around it, one status line that says what the hand can
/// do. It owns the session and everything that shows it.
class MainWindow : public QMainWindow {
  Q_OBJECT

 public:
  explicit MainWindow(engine::LiveOptions options = {});
  ~MainWindow() override;

  [[nodiscard]] Session& session() { return *session_; }
  [[nodiscard]] Viewport& view() { return *view_; }

  /// What cannot be opened is told, and the window stays as it was.
  bool openProject(const QString& file);
  void openFiles(const QStringList& files);  ///< a project, or meshes for a new one
  bool save();                               ///< asks for a name where there is none
  bool saveTo(const QString& file);
  /// Every key of the window with what it does.
  [[nodiscard]] QAction* act(const QString& name) const;
  /// Everything asked for has been computed and drawn.
  [[nodiscard]] bool isQuiet() const;

 public slots:
  void newProject(const QStringList& files = {});
  void openExample();

 protected:
  void closeEvent(QCloseEvent* event) override;
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;

 private:
  std::unique_ptr<Session> session_;
  bool refining_ = false;  // as it began; the menu's mark tells from then on
  Background background_;

  QStackedWidget* pages_ = nullptr;
  StartPage* start_ = nullptr;
  Viewport* view_ = nullptr;
  std::unique_ptr<Viewport> unshown_;  // the view where it cannot be shown
  QString noPicture_;                  // why the view cannot be shown; empty: it can
  QLabel* instead_ = nullptr;
  std::unique_ptr<SelectTool> selectTool_;
  std::unique_ptr<DrawTool> drawTool_;
  std::unique_ptr<ClickTool> clickTool_;
  Tool* tool_ = nullptr;

  QList<QDockWidget*> docks_;
  QToolBar* tools_ = nullptr;
  QLabel* hint_ = nullptr;
  QLabel* stage_ = nullptr;
  QLabel* figures_ = nullptr;
  QProgressBar* progress_ = nullptr;
  QToolButton* stop_ = nullptr;
  NavigationPreset navigation_ = NavigationPreset::Blender;

  // menus (main_window_actions.cpp)
  QAction* add(const char* name, const QString& text, const QKeySequence& keys,
               std::function<void()> act);
  void makeActions();
  void makeMenus();
  void makeToolBar();
  // the rest (main_window.cpp)
  void makePanels();
  void makeStatusLine();
  void useTool(Tool* tool);
  void carryOut(const Edit& edit);
  void mirrorSelected();
  void exportBuild();
  void saveScript();
  void chooseTheme(Theme theme);
  void chooseNavigation(NavigationPreset preset);
  void refresh();
  void showProgress(const QString& stage, double fraction);
  bool mayLeave();
  void remember(const QString& file);
  void tellError(const Error& error);
  void finishNew(const std::shared_ptr<Result<authoring::NewProject>>& made,
                 const std::filesystem::path& target);
};

}  // namespace ecorche::studio
