#include <ecorche/studio/main_window.h>
#include <ecorche/studio/shortcut_sheet.h>

#include <QActionGroup>
#include <QApplication>
#include <QDockWidget>
#include <QFileDialog>
#include <QMenuBar>
#include <QMessageBox>
#include <QSettings>
#include <QToolBar>

namespace ecorche::studio {

QAction* MainWindow::add(const char* name, const QString& text, const QKeySequence& keys,
                         std::function<void()> act) {
  auto* action = new QAction(text, this);
  action->setObjectName(name);
  action->setShortcut(keys);
  connect(action, &QAction::triggered, this, std::move(act));
  addAction(action);
  return action;
}

QAction* MainWindow::act(const QString& name) const { return findChild<QAction*>(name); }

void MainWindow::makeActions() {
  add("new", tr("&New from skin and bones …"), QKeySequence::New, [this] { newProject(); });
  add("open", tr("&Open …"), QKeySequence::Open, [this] {
    if (!mayLeave()) return;
    const QString file =
        QFileDialog::getOpenFileName(this, tr("Open a project"), {}, tr("Projects (*.ecorche)"));
    if (!file.isEmpty()) openProject(file);
  });
  add("save", tr("&Save"), QKeySequence::Save, [this] { save(); });
  add("saveAs", tr("Save &as …"), QKeySequence::SaveAs, [this] {
    const QString file =
        QFileDialog::getSaveFileName(this, tr("Save the project"), {}, tr("Projects (*.ecorche)"));
    if (!file.isEmpty()) saveTo(file);
  });
  add("saveScript", tr("Save what was done as a script …"), {}, [this] { saveScript(); });
  add("export", tr("&Build and export …"), tr("Ctrl+E"), [this] { exportBuild(); });
  add("reload", tr("Read meshes again"), tr("F5"), [this] { session_->reloadMeshes(); });
  add("quit", tr("&Quit"), QKeySequence::Quit, [this] { close(); });

  add("undo", tr("&Undo"), QKeySequence::Undo, [this] { session_->undo(); });
  add("redo", tr("&Redo"), QKeySequence(tr("Ctrl+Shift+Z")), [this] { session_->redo(); });
  add("delete", tr("&Delete"), QKeySequence::Delete,
      [this] { carryOut(removeSelected(*session_)); });
  add("duplicate", tr("D&uplicate"), tr("Ctrl+D"), [this] { carryOut(duplicate(*session_)); });
  add("mirror", tr("&Mirror"), tr("M"), [this] { mirrorSelected(); });
  add("protect", tr("&Protect, or lift that"), tr("Ctrl+L"), [this] {
    if (const model::Tissue* tissue = session_->selectedTissue())
      carryOut(protectSelected(*session_, !tissue->isProtected));
  });
  add("split", tr("&Split at the point"), tr("Ctrl+K"),
      [this] { carryOut(splitCurve(*session_)); });
  add("thicker", tr("Thicker"), tr("+"), [this] { carryOut(thicken(*session_, 1.1)); });
  add("thinner", tr("Thinner"), tr("-"), [this] { carryOut(thicken(*session_, 1.0 / 1.1)); });

  auto* group = new QActionGroup(this);
  const auto tool = [&](const char* name, const QString& text, const QKeySequence& keys,
                        Glyph glyph, std::function<void()> use) {
    QAction* action = add(name, text, keys, std::move(use));
    action->setCheckable(true);
    action->setIcon(icon(glyph, palette().color(QPalette::ButtonText)));
    action->setToolTip(QString("%1  %2").arg(QString(text).remove('&'), keys.toString()));
    group->addAction(action);
    return action;
  };
  tool("select", tr("&Select and move"), tr("V"), Glyph::Select, [this] {
    useTool(selectTool_.get());
  })->setChecked(true);
  tool("draw", tr("&Draw a muscle"), tr("D"), Glyph::Draw, [this] {
    drawTool_->setAddHead(false);
    useTool(drawTool_.get());
  });
  tool("drawHead", tr("Draw another &head"), tr("Shift+D"), Glyph::Polyline, [this] {
    drawTool_->setAddHead(true);
    useTool(drawTool_.get());
  });
  tool("click", tr("&Click from bone to bone"), tr("L"), Glyph::Straight,
       [this] { useTool(clickTool_.get()); });
  QAction* planes = add("endsOnPlanes", tr("Ends may sit on cut planes"), {},
                        [this] { drawTool_->setEndsOnPlanes(act("endsOnPlanes")->isChecked()); });
  QAction* muscles = add("endsOnMuscles", tr("Ends may sit on muscles"), {}, [this] {
    drawTool_->setEndsOnMuscles(act("endsOnMuscles")->isChecked());
  });
  QAction* refine = add("refine", tr("&Refine around muscles"), {}, [this] {
    const bool on = act("refine")->isChecked();
    QSettings().setValue("refine", on);
    session_->setRefining(on);
  });
  refine->setCheckable(true);
  refine->setChecked(refining_);
  refine->setToolTip(tr("When the hand rests, tets are made anew: small where muscles meet"));
  planes->setCheckable(true);
  muscles->setCheckable(true);

  add("frame", tr("&Frame selected"), tr("F"), [this] { view_->frameSelected(); });
  add("frameAll", tr("Frame &all"), tr("Home"), [this] { view_->frameAll(); });
  const auto look = [&](const char* name, const QString& text, const char* key, double az,
                        double el) {
    add(name, text, tr(key), [this, az, el] { view_->lookFrom(az, el); });
  };
  look("front", tr("Front"), "1", 0, 0);
  look("back", tr("Back"), "Ctrl+1", 180, 0);
  look("side", tr("Left"), "3", 90, 0);
  look("otherSide", tr("Right"), "Ctrl+3", -90, 0);
  look("top", tr("Top"), "7", 0, 89.9);
  look("bottom", tr("Bottom"), "Ctrl+7", 0, -89.9);
  QAction* parallel = add("parallel", tr("Parallel rays"), tr("5"),
                          [this] { view_->setParallel(act("parallel")->isChecked()); });
  parallel->setCheckable(true);
  add("hide", tr("&Hide"), tr("H"), [this] {
    const Selection s = session_->selection();
    const std::string name = s.tissue.empty() ? s.bone : s.tissue;
    if (!name.empty()) session_->setHidden(name, !session_->display().hidden.contains(name));
  });
  add("spread", tr("Handles for the spread"), tr("G"), [this] {
    Display display = session_->display();
    display.spread = !display.spread;
    session_->setDisplay(display);
  });
  add("showAll", tr("Show all"), tr("Shift+H"), [this] {
    Display display = session_->display();
    display.hidden.clear();
    display.solo.reset();
    display.xray.reset();
    session_->setDisplay(display);
  });
  add("solo", tr("This one alone"), tr("/"), [this] {
    Display display = session_->display();
    const std::string& name = session_->selection().tissue;
    display.solo = display.solo || name.empty() ? std::nullopt : std::optional(name);
    session_->setDisplay(display);
  });
  add("xray", tr("Through the others"), tr("X"), [this] {
    Display display = session_->display();
    const std::string& name = session_->selection().tissue;
    display.xray = display.xray || name.empty() ? std::nullopt : std::optional(name);
    session_->setDisplay(display);
  });
  add("sheet", tr("&Keys and hands"), tr("F1"), [this] {
    auto* sheet = new ShortcutSheet(actions(), navigation_, this);
    sheet->setAttribute(Qt::WA_DeleteOnClose);
    sheet->show();
  });
  add("about", tr("&About"), {}, [this] {
    QMessageBox::about(this, tr("Écorché"),
                       tr("<b>Écorché</b> models the muscles of any creature from skin, bones and "
                          "curves.<p>After Abdrashitov, Bang, Levin, Singh and Jacobson, "
                          "<i>Interactive Modelling of Volumetric Musculoskeletal Anatomy</i>, ACM "
                          "TOG 2021.<p>Free software, GPL 3 or later. What you model is yours."));
  });
}

void MainWindow::makeMenus() {
  const auto fill = [&](QMenu* menu, const QStringList& names) {
    for (const QString& name : names) {
      if (name.isEmpty()) {
        menu->addSeparator();
      } else {
        menu->addAction(act(name));
      }
    }
  };
  fill(menuBar()->addMenu(tr("&File")),
       {"new", "open", "", "save", "saveAs", "saveScript", "", "export", "reload", "", "quit"});
  fill(menuBar()->addMenu(tr("&Edit")), {"undo", "redo", "", "duplicate", "mirror", "split",
                                         "protect", "delete", "", "thicker", "thinner"});
  fill(menuBar()->addMenu(tr("&Muscle")),
       {"select", "draw", "drawHead", "click", "", "endsOnPlanes", "endsOnMuscles", "", "refine"});
  QMenu* view = menuBar()->addMenu(tr("&View"));
  fill(view, {"frame", "frameAll", "", "front", "back", "side", "otherSide", "top", "bottom",
              "parallel", "", "hide", "solo", "xray", "showAll", "", "spread"});
  view->addSeparator();
  QMenu* panels = view->addMenu(tr("Panels"));
  for (QDockWidget* dock : docks_) panels->addAction(dock->toggleViewAction());
  QMenu* hands = view->addMenu(tr("Navigation"));
  auto* presets = new QActionGroup(this);
  const std::vector<std::pair<QString, NavigationPreset>> all = {
      {tr("Blender"), NavigationPreset::Blender},
      {tr("Maya"), NavigationPreset::Maya},
      {tr("One button"), NavigationPreset::OneButton}};
  for (const auto& [text, preset] : all) {
    QAction* action =
        hands->addAction(text, this, [this, preset = preset] { chooseNavigation(preset); });
    action->setCheckable(true);
    action->setChecked(preset == navigation_);
    presets->addAction(action);
  }
  QMenu* themes = view->addMenu(tr("Theme"));
  themes->addAction(tr("Dark"), this, [this] { chooseTheme(Theme::Dark); });
  themes->addAction(tr("Light"), this, [this] { chooseTheme(Theme::Light); });
  fill(menuBar()->addMenu(tr("&Help")), {"sheet", "about"});
}

void MainWindow::makeToolBar() {
  tools_ = new QToolBar(tr("Tools"), this);
  tools_->setObjectName("tools");
  tools_->setMovable(false);
  tools_->setIconSize({22, 22});
  addToolBar(Qt::LeftToolBarArea, tools_);
  act("mirror")->setIcon(icon(Glyph::Mirror, palette().color(QPalette::ButtonText)));
  act("undo")->setIcon(icon(Glyph::Undo, palette().color(QPalette::ButtonText)));
  act("redo")->setIcon(icon(Glyph::Redo, palette().color(QPalette::ButtonText)));
  act("frame")->setIcon(icon(Glyph::Frame, palette().color(QPalette::ButtonText)));
  for (const char* name : {"select", "draw", "drawHead", "click"}) tools_->addAction(act(name));
  tools_->addSeparator();
  for (const char* name : {"mirror", "undo", "redo", "frame"}) tools_->addAction(act(name));
}

}  // namespace ecorche::studio
