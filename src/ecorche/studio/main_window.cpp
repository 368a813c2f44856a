#include <ecorche/core/files.h>
#include <ecorche/engine/build.h>
#include <ecorche/engine/output.h>
#include <ecorche/mesh/write_mesh.h>
#include <ecorche/model/project_file.h>
#include <ecorche/studio/display_panel.h>
#include <ecorche/studio/examples.h>
#include <ecorche/studio/history_panel.h>
#include <ecorche/studio/main_window.h>
#include <ecorche/studio/message_panel.h>
#include <ecorche/studio/muscle_list.h>
#include <ecorche/studio/muscle_panel.h>
#include <ecorche/studio/new_dialog.h>
#include <ecorche/studio/start_page.h>

#include <QApplication>
#include <QCloseEvent>
#include <QDockWidget>
#include <QDropEvent>
#include <QFileDialog>
#include <QFileInfo>
#include <QLabel>
#include <QLocale>
#include <QMessageBox>
#include <QMimeData>
#include <QProgressBar>
#include <QScrollArea>
#include <QSettings>
#include <QStackedWidget>
#include <QStatusBar>
#include <QTimer>
#include <QToolBar>
#include <QToolButton>

namespace ecorche::studio {

namespace {

QColor screenColour(const render::Rgba& c) {
  return QColor(QString::fromStdString(render::hexFromColour(c)));
}

}  // namespace

MainWindow::MainWindow(engine::LiveOptions options)
    : session_(std::make_unique<Session>(options)), refining_(options.refine) {
  setObjectName("mainWindow");
  setAcceptDrops(true);
  resize(1440, 900);
  const QSettings settings;
  navigation_ = static_cast<NavigationPreset>(settings.value("navigation", 0).toInt());

  pages_ = new QStackedWidget(this);
  start_ = new StartPage(pages_);
  noPicture_ = Viewport::troubleOfMachine();
  pages_->addWidget(start_);
  if (noPicture_.isEmpty()) {
    view_ = new Viewport(*session_, pages_);
    pages_->addWidget(view_);
  } else {
    // In no window: Qt draws all of one that holds a view through OpenGL, and crashes where it
    // cannot
    unshown_ = std::make_unique<Viewport>(*session_);
    view_ = unshown_.get();
  }
  instead_ =
      new QLabel(tr("There is no picture: %1.\n\nProjects can be opened, edited by the panels, "
                    "built and saved all the same.")
                     .arg(noPicture_),
                 pages_);
  instead_->setObjectName("noPicture");
  instead_->setAlignment(Qt::AlignCenter);
  instead_->setWordWrap(true);
  instead_->setMargin(60);
  pages_->addWidget(instead_);
  setCentralWidget(pages_);
  start_->setRecent(settings.value("recent").toStringList());
  connect(start_, &StartPage::newAsked, this, [this] { newProject(); });
  connect(start_, &StartPage::openAsked, this, [this] { act("open")->trigger(); });
  connect(start_, &StartPage::exampleAsked, this, &MainWindow::openExample);
  connect(start_, &StartPage::fileAsked, this, &MainWindow::openProject);

  selectTool_ = std::make_unique<SelectTool>(view_->toolView());
  drawTool_ = std::make_unique<DrawTool>(view_->toolView());
  clickTool_ = std::make_unique<ClickTool>(view_->toolView());
  makePanels();
  makeActions();
  makeMenus();
  makeToolBar();
  makeStatusLine();
  useTool(selectTool_.get());
  chooseNavigation(navigation_);
  view_->setColours(sceneColours(static_cast<Theme>(settings.value("theme", 0).toInt())));

  connect(session_.get(), &Session::projectChanged, this, &MainWindow::refresh);
  connect(session_.get(), &Session::selectionChanged, this, &MainWindow::refresh);
  connect(session_.get(), &Session::liveChanged, this, &MainWindow::refresh);
  connect(session_.get(), &Session::volumesChanged, this, &MainWindow::refresh);
  connect(session_.get(), &Session::settledChanged, this, &MainWindow::refresh);
  connect(session_.get(), &Session::progressed, this, &MainWindow::showProgress);
  connect(&background_, &Background::progressed, this, &MainWindow::showProgress);
  connect(session_.get(), &Session::told, this, [this](Severity severity, const QString& text) {
    // The line below is read at once; the list keeps it
    statusBar()->showMessage(text, severity == Severity::Note ? 4000 : 9000);
  });
  connect(view_, &Viewport::troubled, this, [this](const QString& why) {
    session_->tell(Severity::Error, tr("There is no picture: %1").arg(why));
  });
  if (!noPicture_.isEmpty()) {
    QTimer::singleShot(0, this, [this] {
      session_->tell(Severity::Error, tr("There is no picture: %1").arg(noPicture_));
    });
  }
  refresh();
}

// The view looks at the session and at a tool, and may be told that the hand has left it while the
// window goes: it goes before them.
MainWindow::~MainWindow() {
  view_->setTool(nullptr);
  if (!unshown_) delete view_;
}

void MainWindow::makePanels() {
  setDockOptions(AnimatedDocks | AllowTabbedDocks | AllowNestedDocks);
  const auto dock = [&](const QString& title, const char* name, QWidget* inner, bool scrolls,
                        Qt::DockWidgetArea area) {
    auto* out = new QDockWidget(title, this);
    out->setObjectName(name);
    QWidget* shown = inner;
    if (scrolls) {
      auto* scroll = new QScrollArea(out);
      scroll->setWidget(inner);
      scroll->setWidgetResizable(true);
      scroll->setFrameShape(QFrame::NoFrame);
      shown = scroll;
    }
    out->setWidget(shown);
    addDockWidget(area, out);
    docks_ << out;
    return out;
  };
  auto* list = new MuscleList(
      *session_,
      [this](std::size_t place) {
        const auto& colours = view_->scenes().tissueColours(
            session_->project(), session_->tissues(), session_->display().palette);
        return place < colours.size() ? screenColour(colours[place]) : QColor(Qt::gray);
      },
      this);
  connect(list, &MuscleList::deleteAsked, this, [this] { act("delete")->trigger(); });
  connect(list, &MuscleList::duplicateAsked, this, [this] { act("duplicate")->trigger(); });
  connect(list, &MuscleList::mirrorAsked, this, [this] { act("mirror")->trigger(); });
  auto* messages = new MessagePanel(*session_, this);
  connect(messages, &MessagePanel::flyTo, view_, &Viewport::flyTo);

  QDockWidget* muscles = dock(tr("Muscles"), "musclesDock", list, false, Qt::RightDockWidgetArea);
  QDockWidget* muscle = dock(tr("Muscle"), "muscleDock", new MusclePanel(*session_, this), true,
                             Qt::RightDockWidgetArea);
  QDockWidget* display = dock(tr("View"), "viewDock", new DisplayPanel(*session_, this), true,
                              Qt::RightDockWidgetArea);
  QDockWidget* history = dock(tr("History"), "historyDock", new HistoryPanel(*session_, this),
                              false, Qt::RightDockWidgetArea);
  QDockWidget* told =
      dock(tr("Messages"), "messagesDock", messages, false, Qt::RightDockWidgetArea);
  splitDockWidget(muscles, muscle, Qt::Vertical);
  tabifyDockWidget(muscle, display);
  tabifyDockWidget(display, history);
  tabifyDockWidget(history, told);
  muscle->raise();
  resizeDocks({muscles, muscle}, {330, 330}, Qt::Horizontal);
  resizeDocks({muscles, muscle}, {380, 420}, Qt::Vertical);
}

void MainWindow::makeStatusLine() {
  hint_ = new QLabel(this);
  hint_->setObjectName("hint");
  stage_ = new QLabel(this);
  progress_ = new QProgressBar(this);
  progress_->setMaximumSize(140, 12);
  progress_->setTextVisible(false);
  progress_->setRange(0, 1000);
  stop_ = new QToolButton(this);
  stop_->setText(tr("Stop"));
  figures_ = new QLabel(this);
  figures_->setObjectName("figures");
  statusBar()->addWidget(hint_, 1);
  statusBar()->addPermanentWidget(stage_);
  statusBar()->addPermanentWidget(progress_);
  statusBar()->addPermanentWidget(stop_);
  statusBar()->addPermanentWidget(figures_);
  connect(stop_, &QToolButton::clicked, this, [this] {
    background_.cancel();
    session_->stopComputing();
  });
}

void MainWindow::useTool(Tool* tool) {
  if (tool_ != nullptr) tool_->disconnect(this);
  tool_ = tool;
  view_->setTool(tool);
  connect(tool, &Tool::hintChanged, this, [this] { hint_->setText(tool_->hint()); });
  hint_->setText(tool->hint());
}

void MainWindow::carryOut(const Edit& edit) {
  if (edit.commands.empty()) return;
  if (session_->perform(edit.commands, edit.label)) session_->select(edit.select);
}

void MainWindow::mirrorSelected() {
  if (session_->selectedTissue() == nullptr) {
    session_->tell(Severity::Note, tr("Select a muscle to mirror"));
    return;
  }
  if (const auto plane = session_->mirrorPlane()) carryOut(mirrored(*session_, *plane));
}

void MainWindow::refresh() {
  const bool open = session_->isOpen();
  QWidget* const view = noPicture_.isEmpty() ? static_cast<QWidget*>(view_) : instead_;
  pages_->setCurrentWidget(open ? view : start_);
  for (QDockWidget* dock : docks_) {
    if (!open) dock->hide();
  }
  if (open && docks_.front()->property("shownOnce").isNull()) {
    docks_.front()->setProperty("shownOnce", true);
    for (QDockWidget* dock : docks_) dock->show();
    docks_[1]->raise();
  }
  tools_->setVisible(open);
  const auto enable = [&](const char* name, bool on) { act(name)->setEnabled(on); };
  const bool selected = session_->selectedTissue() != nullptr;
  for (const char* name : {"save", "saveAs", "saveScript", "export", "reload", "draw", "drawHead",
                           "click", "select", "frame", "frameAll"})
    enable(name, open);
  for (const char* name : {"delete", "duplicate", "mirror", "thicker", "thinner", "solo"})
    enable(name, selected);
  enable("split", selected && session_->selection().point > 0);
  enable("undo", session_->history().canUndo());
  enable("redo", session_->history().canRedo());
  const auto& steps = session_->history().steps();
  const std::size_t done = session_->history().stepsDone();
  act("undo")->setText(
      done > 0 ? tr("&Undo “%1”").arg(QString::fromStdString(steps[done - 1].label)) : tr("&Undo"));
  act("redo")->setText(done < steps.size()
                           ? tr("&Redo “%1”").arg(QString::fromStdString(steps[done].label))
                           : tr("&Redo"));

  const QString file = QString::fromStdString(session_->file().filename().string());
  setWindowTitle(open ? tr("%1[*] – Écorché").arg(file.isEmpty() ? tr("Untitled") : file)
                      : tr("Écorché"));
  setWindowModified(open && !session_->isSaved());
  const bool busy = !session_->isSettled() || background_.isBusy();
  for (QWidget* w : {static_cast<QWidget*>(stage_), static_cast<QWidget*>(progress_),
                     static_cast<QWidget*>(stop_)})
    w->setVisible(busy);
  if (tool_ != nullptr && open) hint_->setText(tool_->hint());
  QStringList figures;
  if (session_->tissues()) {
    const auto& domain = session_->tissues()->domain->domain;
    double muscle = 0.0;
    for (const model::Tissue& t : session_->project().tissues) {
      if (t.kind == model::Tissue::Kind::Muscle) muscle += session_->volumeOf(t.name).value_or(0.0);
    }
    figures << tr("%1 cm³ of muscle").arg(QLocale().toString(1e6 * muscle, 'f', 0))
            << tr("%1 k tets").arg(domain.mesh.T.rows() / 1000)
            << tr("%1 s").arg(QLocale().toString(session_->tissues()->seconds, 'f', 2));
  }
  figures_->setText(figures.join(" · "));
}

void MainWindow::showProgress(const QString& stage, double fraction) {
  stage_->setText(stage);
  progress_->setValue(static_cast<int>(1000 * fraction));
  refresh();
}

bool MainWindow::openProject(const QString& file) {
  const std::filesystem::path path = std::filesystem::absolute(file.toStdString());
  auto project = model::loadProject(path);
  if (!project) {
    tellError(project.error());
    return false;
  }
  session_->start(std::move(*project), path, true);
  remember(QString::fromStdString(path.string()));
  return true;
}

void MainWindow::openExample() {
  const auto file = exampleFile("arm/arm.ecorche");
  if (!file) return tellError(file.error());
  auto project = model::loadProject(*file);
  if (!project) return tellError(project.error());
  // Under no name: what is done to it is not done to the example
  session_->start(std::move(*project), {}, true);
}

void MainWindow::openFiles(const QStringList& files) {
  if (files.isEmpty() || !mayLeave()) return;
  if (files.size() == 1 && files.front().endsWith(".ecorche", Qt::CaseInsensitive)) {
    openProject(files.front());
  } else {
    newProject(files);
  }
}

void MainWindow::newProject(const QStringList& files) {
  if (background_.isBusy()) {
    session_->tell(Severity::Note, tr("Wait for what is being computed, or stop it"));
    return;
  }
  auto* dialog = new NewDialog(this);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->take(files);
  connect(dialog, &QDialog::accepted, this, [this, dialog] {
    const authoring::NewProjectRequest request = dialog->request();
    auto made = std::make_shared<Result<authoring::NewProject>>();
    background_.start(
        [request, made](RunContext& run) { *made = authoring::newProject(request, run); },
        [this, made, target = request.target] { finishNew(made, target); });
    refresh();
  });
  dialog->open();
}

void MainWindow::finishNew(const std::shared_ptr<Result<authoring::NewProject>>& made,
                           const std::filesystem::path& target) {
  refresh();
  if (!*made) {
    if (made->error().code != ErrorCode::Cancelled) tellError(made->error());
    return;
  }
  if ((*made)->madeSkin) {
    if (auto written = mesh::writeObj(*(*made)->madeSkin, (*made)->skinFile); !written)
      return tellError(written.error());
  }
  if (auto saved = model::saveProject((*made)->project, target); !saved)
    return tellError(saved.error());
  session_->start((*made)->project, target, true);
  for (const Finding& f : (*made)->findings)
    session_->tell(f.severity, QString::fromStdString(f.message), f.point);
  remember(QString::fromStdString(target.string()));
}

bool MainWindow::save() {
  if (!session_->file().empty()) return saveTo(QString::fromStdString(session_->file().string()));
  const QString file =
      QFileDialog::getSaveFileName(this, tr("Save the project"), {}, tr("Projects (*.ecorche)"));
  return !file.isEmpty() && saveTo(file);
}

bool MainWindow::saveTo(const QString& file) {
  const QString named = file.endsWith(".ecorche") ? file : file + ".ecorche";
  if (auto saved = session_->save(std::filesystem::absolute(named.toStdString())); !saved) {
    tellError(saved.error());
    return false;
  }
  remember(named);
  session_->tell(Severity::Note, tr("Saved %1").arg(named));
  return true;
}

void MainWindow::saveScript() {
  const QString file = QFileDialog::getSaveFileName(this, tr("Save a script for ecorche run"), {},
                                                    tr("Text (*.txt)"));
  if (file.isEmpty()) return;
  if (auto written = writeFileWhole(file.toStdString(), session_->script()); !written)
    tellError(written.error());
}

void MainWindow::exportBuild() {
  if (background_.isBusy()) {
    session_->tell(Severity::Note, tr("Wait for what is being computed, or stop it"));
    return;
  }
  const QString folder = QFileDialog::getSaveFileName(this, tr("Build into a new folder"), {}, {},
                                                      nullptr, QFileDialog::ShowDirsOnly);
  if (folder.isEmpty()) return;
  auto result = std::make_shared<Result<void>>();
  background_.start(
      [project = session_->project(), folder = folder.toStdString(), result](RunContext& run) {
        const auto built = engine::build(project, {}, run);
        if (!built) {
          *result = passOn(built);
          return;
        }
        const auto report = engine::writeBuild(project, *built, folder, {}, run);
        if (!report) *result = passOn(report);
      },
      [this, folder, result] {
        refresh();
        if (!*result) {
          if (result->error().code != ErrorCode::Cancelled) tellError(result->error());
          return;
        }
        session_->tell(Severity::Note, tr("Built and exported to %1").arg(folder));
      });
  refresh();
}

void MainWindow::chooseTheme(Theme theme) {
  QSettings().setValue("theme", static_cast<int>(theme));
  applyTheme(*qApp, theme);
  view_->setColours(sceneColours(theme));
}

void MainWindow::chooseNavigation(NavigationPreset preset) {
  navigation_ = preset;
  view_->setNavigation(preset);
  QSettings().setValue("navigation", static_cast<int>(preset));
}

bool MainWindow::isQuiet() const {
  if (background_.isBusy() || !session_->isSettled()) return false;
  return pages_->currentWidget() != view_ || view_->isFinished();
}

bool MainWindow::mayLeave() {
  if (!session_->isOpen() || session_->isSaved()) return true;
  const auto answer = QMessageBox::question(
      this, tr("Unsaved work"), tr("Save what was done before it is closed?"),
      QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel, QMessageBox::Save);
  if (answer == QMessageBox::Save) return save();
  return answer == QMessageBox::Discard;
}

void MainWindow::remember(const QString& file) {
  QSettings settings;
  QStringList recent = settings.value("recent").toStringList();
  recent.removeAll(file);
  recent.prepend(file);
  while (recent.size() > 12) recent.removeLast();
  settings.setValue("recent", recent);
  start_->setRecent(recent);
}

void MainWindow::tellError(const Error& error) {
  session_->tell(Severity::Error, QString::fromStdString(error.text()), error.place.point);
  auto* box = new QMessageBox(QMessageBox::Warning, tr("That did not work"),
                              QString::fromStdString(error.text()), QMessageBox::Ok, this);
  box->setAttribute(Qt::WA_DeleteOnClose);
  box->open();
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (mayLeave()) {
    event->accept();
  } else {
    event->ignore();
  }
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  QStringList files;
  for (const QUrl& url : event->mimeData()->urls()) {
    if (url.isLocalFile()) files << url.toLocalFile();
  }
  event->acceptProposedAction();
  openFiles(files);
}

void MainWindow::keyPressEvent(QKeyEvent* event) {
  if (event->key() == Qt::Key_Escape && tool_ != nullptr && tool_->cancel()) return;
  QMainWindow::keyPressEvent(event);
}

}  // namespace ecorche::studio
