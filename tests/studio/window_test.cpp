// An artist's first hour, in a real window: mouse and keys, pictures, files.
#include <ecorche/core/files.h>
#include <ecorche/model/project_file.h>

#include <QDialog>
#include <QLineEdit>
#include <QListWidget>
#include <QMessageBox>
#include <QProcess>
#include <QPushButton>
#include <QTreeWidget>
#include <catch2/catch.hpp>

#include <ecorche/studio/spread_gizmo.h>

#include "studio/hand.h"
#include "support/program.h"

using namespace ecorche;
using namespace ecorche::studio;
using mesh::Vector3;
using test::Hand;
using test::waitFor;

namespace {

std::unique_ptr<MainWindow> openWindow() {
  test::application();
  auto window = std::make_unique<MainWindow>(engine::LiveOptions{.tets = 60'000});
  window->resize(1280, 800);
  window->show();
  REQUIRE(QTest::qWaitForWindowExposed(window.get()));
  // Keys go to the active window, and a screen without a window manager makes none active
  QApplication::setActiveWindow(window.get());
  REQUIRE(QApplication::activeWindow() == window.get());
  return window;
}

// A pixel well inside what is seen of a bone, near a share of the way along the bone's longest side
QPoint pixelOn(MainWindow& window, const std::string& bone, double along) {
  const auto& meshes = *window.session().meshes();
  for (const mesh::SurfaceMesh& m : meshes.meshes.bones) {
    if (m.name != bone) continue;
    const mesh::Box box = mesh::boundingBox(m);
    int axis = 0;
    (box.hi - box.lo).maxCoeff(&axis);
    const double wanted = box.lo[axis] + along * (box.hi - box.lo)[axis];
    QPoint best;
    double least = 1e9;
    for (Eigen::Index v = 0; v < m.V.rows(); ++v) {
      const auto seen = window.view().eye().pixelOf(m.V.row(v).transpose());
      const double off = std::abs(m.V(v, axis) - wanted);
      if (!seen || off >= least) continue;
      bool inside = true;
      for (const Eigen::Vector2d& by : {Eigen::Vector2d(0, 0), Eigen::Vector2d(2, 0),
                                        Eigen::Vector2d(-2, 0), Eigen::Vector2d(0, 2)}) {
        const auto hit = boneUnder(window.view().eye().sight(*seen + by), meshes,
                                   window.session().project(), window.session().display());
        inside = inside && hit && hit->bone == bone;
      }
      if (!inside) continue;
      least = off;
      best = Hand::pointOf(*seen);
    }
    REQUIRE(least < 1e9);
    return best;
  }
  FAIL("no bone " << bone);
  return {};
}

void copyArm(const std::filesystem::path& folder) {
  const std::filesystem::path arm = std::filesystem::path(ECORCHE_SOURCE_DIR) / "examples/arm";
  for (const char* file : {"skin.obj", "bones.obj"})
    std::filesystem::copy_file(arm / file, folder / file);
}

}  // namespace

TEST_CASE("an artist draws a muscle, edits it, and finds everything again") {
  test::TempFolder temp;
  copyArm(temp.path());
  const QString file = QString::fromStdString((temp.path() / "mine.ecorche").string());
  std::string script;
  model::Project saved;
  {
    auto window = openWindow();
    Hand hand(*window);
    Session& session = window->session();
    QTest::qWait(50);
    hand.keep("01-start");

    // From the start page: skin and bones
    QTest::mouseClick(window->findChild<QPushButton*>("startNew"), Qt::LeftButton);
    auto* dialog = window->findChild<QDialog*>("newDialog");
    REQUIRE(dialog != nullptr);
    const auto type = [&](const char* line, const std::string& text) {
      auto* edit = dialog->findChild<QLineEdit*>(line);
      edit->selectAll();
      QTest::keyClicks(edit, QString::fromStdString(text));
    };
    type("newSkin", (temp.path() / "skin.obj").string());
    type("newBones", (temp.path() / "bones.obj").string());
    type("newTarget", file.toStdString());
    hand.keep("02-new");
    QTest::keyClick(dialog, Qt::Key_Return);
    REQUIRE(waitFor([&] { return session.isOpen() && session.meshes() && session.isSettled(); }));
    REQUIRE(session.meshes()->bones.size() == 6);
    REQUIRE(session.domain());
    hand.keep("03-arm");
    const QImage bare = hand.look();

    // A stroke from humerus to radius
    hand.key(Qt::Key_D);
    const QPoint from = pixelOn(*window, "humerus", 0.5);
    const QPoint to = pixelOn(*window, "radius", 0.6);
    QElapsedTimer clock;
    clock.start();
    hand.drag({from, (from + to) / 2 + QPoint(12, 0), to});
    for (int i = 0; i < window->findChild<QListWidget*>("messages")->count(); ++i)
      UNSCOPED_INFO(window->findChild<QListWidget*>("messages")->item(i)->text().toStdString());
    WARN("the stroke took " << clock.elapsed() << " ms");
    REQUIRE(session.project().tissues.size() == 1);
    const model::Curve drawn = session.project().tissues[0].curves.at(0);
    CHECK(drawn.start == model::Support{model::Support::On::Bone, "humerus"});
    CHECK(drawn.end == model::Support{model::Support::On::Bone, "radius"});
    REQUIRE(waitFor([&] { return session.volumeOf("muscle").value_or(0.0) > 0.0; }));
    WARN("a muscle " << clock.elapsed() << " ms after its stroke began");
    REQUIRE(hand.settle());
    hand.keep("04-drawn");
    const QImage withMuscle = hand.look();
    CHECK(test::changedShare(bare, withMuscle) > 0.005);
    const double volume = *session.volumeOf("muscle");
    CHECK(volume > 20e-6);
    CHECK(volume < 3000e-6);

    // Its middle point, dragged
    hand.key(Qt::Key_V);
    const std::size_t middle = drawn.points.size() / 2;
    const QPoint at = Hand::pointOf(*window->view().eye().pixelOf(drawn.points[middle].at));
    hand.drag({at, at + QPoint(-9, 2)});
    const Vector3 moved = session.project().tissues[0].curves[0].points[middle].at;
    CHECK((moved - drawn.points[middle].at).norm() > 1e-3);
    CHECK(session.selection().point == static_cast<int>(middle));
    REQUIRE(hand.settle());
    hand.keep("05-dragged");
    const QImage dragged = hand.look();
    CHECK(test::changedShare(withMuscle, dragged) > 0.002);

    // Its value, raised by the wheel
    const double before = *session.volumeOf("muscle");
    for (int k = 0; k < 4; ++k) {
      QWheelEvent wheel(at, window->view().mapToGlobal(at), {}, {120, 0}, Qt::NoButton,
                        Qt::AltModifier, Qt::NoScrollPhase, false);
      QApplication::sendEvent(&window->view(), &wheel);
    }
    CHECK(session.project().tissues[0].curves[0].points[middle].tissue > 1.4);
    REQUIRE(hand.settle());
    REQUIRE(waitFor([&] { return *session.volumeOf("muscle") > 1.02 * before; }));
    hand.keep("06-thicker");

    // Hidden and shown
    hand.key(Qt::Key_H);
    CHECK(session.display().hidden.contains("muscle"));
    hand.keep("07-hidden");
    CHECK(test::changedShare(bare, hand.look()) < 0.02);
    hand.key(Qt::Key_H, Qt::ShiftModifier);
    CHECK(session.display().hidden.empty());

    // Mirrored: two muscles, left and right by name
    hand.key(Qt::Key_M);
    REQUIRE(session.project().tissues.size() == 2);
    CHECK(((session.project().tissues[0].name == "muscle_L" &&
            session.project().tissues[1].name == "muscle_R") ||
           (session.project().tissues[0].name == "muscle_R" &&
            session.project().tissues[1].name == "muscle_L")));
    REQUIRE(hand.settle());
    hand.keep("08-mirrored");

    // Everything undone, everything done again
    const model::Project all = session.project();
    const std::size_t steps = session.history().stepsDone();
    while (session.history().canUndo()) hand.key(Qt::Key_Z, Qt::ControlModifier);
    CHECK(session.project().tissues.empty());
    REQUIRE(hand.settle());
    hand.keep("09-undone");
    CHECK(test::changedShare(bare, hand.look()) < 0.002);
    while (session.history().canRedo())
      hand.key(Qt::Key_Z, Qt::ControlModifier | Qt::ShiftModifier);
    CHECK(session.project() == all);
    CHECK(session.history().stepsDone() == steps);
    CHECK(window->findChild<QListWidget*>("history")->count() == static_cast<int>(steps) + 1);
    // The image may lie outside the skin: what is saved keeps what can be built
    hand.key(Qt::Key_Z, Qt::ControlModifier);
    REQUIRE(hand.settle());
    CHECK(session.project().tissues.size() == 1);

    hand.key(Qt::Key_S, Qt::ControlModifier);
    CHECK(session.isSaved());
    CHECK_FALSE(window->isWindowModified());
    hand.keep("10-saved");
    saved = session.project();
    script = session.script();
    CHECK(window->close());
  }

  // Found again in a new window
  {
    auto window = openWindow();
    Hand hand(*window);
    REQUIRE(window->openProject(file));
    REQUIRE(hand.settle());
    CHECK(window->session().project() == saved);
    CHECK(window->session().volumeOf("muscle").value_or(0.0) > 20e-6);
    hand.keep("11-again");
    CHECK(window->close());
  }

  // The same by a line of text each
  test::TempFolder again;
  copyArm(again.path());
  CHECK(test::runEcorche("new --skin skin.obj --bones bones.obj --symmetry none -o mine.ecorche",
                         again.path())
            .exitCode == 0);
  REQUIRE(writeFileWhole(again.path() / "session.txt", script));
  const auto run = test::runEcorche("run mine.ecorche session.txt", again.path());
  INFO(run.err);
  CHECK(run.exitCode == 0);
  CHECK(readFile(again.path() / "mine.ecorche").value() ==
        readFile(temp.path() / "mine.ecorche").value());

  const auto built = test::runEcorche("build mine.ecorche -o out --tets 60k", temp.path());
  INFO(built.err);
  CHECK(built.exitCode == 0);
  CHECK(test::runEcorche("check out", temp.path()).exitCode == 0);
}

TEST_CASE("what cannot be opened is told, and the window goes on") {
  test::TempFolder temp;
  auto window = openWindow();
  Hand hand(*window);
  const auto told = [&] {
    auto* box = window->findChild<QMessageBox*>();
    REQUIRE(box != nullptr);
    const QString text = box->text();
    delete box;
    return text.toStdString();
  };
  CHECK_FALSE(window->openProject(QString::fromStdString((temp.path() / "none.ecorche").string())));
  CHECK_THAT(told(), Catch::Contains("none.ecorche"));
  REQUIRE(writeFileWhole(temp.path() / "broken.ecorche", "{\"schema\": 1,\n \"skin\": 7}"));
  CHECK_FALSE(
      window->openProject(QString::fromStdString((temp.path() / "broken.ecorche").string())));
  CHECK_THAT(told(), Catch::Contains("broken.ecorche:2"));
  CHECK_FALSE(window->session().isOpen());

  // A mesh that is gone: the project opens, the message says which file, and the way back works
  copyArm(temp.path());
  REQUIRE(test::runEcorche("new --skin skin.obj --bones bones.obj --symmetry none -o arm.ecorche",
                           temp.path())
              .exitCode == 0);
  std::filesystem::rename(temp.path() / "skin.obj", temp.path() / "elsewhere.obj");
  CHECK(window->openProject(QString::fromStdString((temp.path() / "arm.ecorche").string())));
  REQUIRE(hand.settle());
  auto* messages = window->findChild<QListWidget*>("messages");
  REQUIRE(messages->count() > 0);
  CHECK_THAT(messages->item(0)->text().toStdString(), Catch::Contains("skin.obj"));
  CHECK_FALSE(window->session().meshes());
  hand.keep("20-mesh-gone");
  std::filesystem::rename(temp.path() / "elsewhere.obj", temp.path() / "skin.obj");
  CHECK(window->openProject(QString::fromStdString((temp.path() / "arm.ecorche").string())));
  REQUIRE(hand.settle());
  CHECK(window->session().domain());
}

TEST_CASE("without OpenGL the window says so, and the rest works") {
  test::application();
  test::TempFolder temp;
  const QString shot = QString::fromStdString((temp.path() / "shot.png").string());
  QProcess studio;
  QProcessEnvironment environment = QProcessEnvironment::systemEnvironment();
  environment.insert("QT_XCB_GL_INTEGRATION", "none");
  studio.setProcessEnvironment(environment);
  studio.start(QString(ECORCHE_BIN_DIR) + "/ecorche-studio",
               {"--tets", "20000", "--screenshot", shot,
                QString(ECORCHE_SOURCE_DIR) + "/examples/arm/arm.ecorche"});
  REQUIRE(studio.waitForFinished(120'000 * test::kPatience));
  const std::string said = studio.readAllStandardError().toStdString();
  INFO(said);
  CHECK(studio.exitStatus() == QProcess::NormalExit);
  CHECK(studio.exitCode() == 0);
  CHECK_THAT(said, Catch::Contains("OpenGL 3.3"));
  QImage picture(shot);
  REQUIRE_FALSE(picture.isNull());
  if (const char* folder = std::getenv("ECORCHE_SHOTS"))
    CHECK(picture.save(QString(folder) + "/30-no-opengl.png"));
}

TEST_CASE("a stroke that ends beside the bones draws nothing and says so") {
  test::TempFolder temp;
  auto window = openWindow();
  Hand hand(*window);
  window->openExample();
  REQUIRE(waitFor([&] { return window->session().meshes() != nullptr; }));
  const std::size_t before = window->session().project().tissues.size();
  hand.key(Qt::Key_D);
  hand.drag({pixelOn(*window, "humerus", 0.5), QPoint(30, 40)});
  CHECK(window->session().project().tissues.size() == before);
  auto* messages = window->findChild<QListWidget*>("messages");
  REQUIRE(messages->count() > 0);
  CHECK_THAT(messages->item(0)->text().toStdString(), Catch::Contains("has to end on a bone"));

  // Given up with Esc in the middle: nothing either
  const QPoint on = pixelOn(*window, "humerus", 0.5);
  QTest::mousePress(&window->view(), Qt::LeftButton, {}, on);
  hand.key(Qt::Key_Escape);
  QTest::mouseRelease(&window->view(), Qt::LeftButton, {}, pixelOn(*window, "radius", 0.5));
  CHECK(window->session().project().tissues.size() == before);
  CHECK(window->session().history().stepsDone() == 0);
}

TEST_CASE("handles of the spread are seen, pulled, kept as a step and gone when protected") {
  auto window = openWindow();
  Hand hand(*window);
  Session& session = window->session();
  REQUIRE(window->openProject(QString::fromStdString(
      (std::filesystem::path(ECORCHE_SOURCE_DIR) / "examples/arm/arm.ecorche").string())));
  REQUIRE(hand.settle());
  session.select({"deltoid", -1, -1, {}});
  const QImage plain = hand.look();

  studio::Display display = session.display();
  display.fibers = true;
  display.skin = false;
  session.setDisplay(display);
  REQUIRE(hand.settle());
  const QImage streaks = hand.look();
  hand.keep("13-fibres");
  display.fibers = false;
  session.setDisplay(display);
  CHECK(test::changedShare(streaks, hand.look()) > 0.002);

  hand.key(Qt::Key_G);
  REQUIRE(session.display().spread);
  CHECK(test::changedShare(plain, hand.look()) > 0.001);
  hand.keep("14-spread");
  const auto gizmo = SpreadGizmo::of(session, window->view().eye());
  REQUIRE(gizmo);
  const QPoint handle = Hand::pointOf(window->view().eye().pixelOf(gizmo->handles()[1]).value());
  const QPoint middle = Hand::pointOf(
      window->view().eye().pixelOf(0.5 * (gizmo->axes()[1][0] + gizmo->axes()[1][1])).value());
  const double before = session.selectedTissue()->anisotropy.lambda3;
  hand.drag({handle, handle + (handle - middle)});
  const double after = session.selectedTissue()->anisotropy.lambda3;
  CHECK(after > 2.0 * before);
  CHECK(session.history().stepsDone() == 1);
  REQUIRE(hand.settle());
  hand.keep("15-spread-pulled");
  hand.key(Qt::Key_Z, Qt::ControlModifier);
  CHECK(session.selectedTissue()->anisotropy.lambda3 == before);

  hand.key(Qt::Key_L, Qt::ControlModifier);
  CHECK(session.selectedTissue()->isProtected);
  CHECK_FALSE(SpreadGizmo::of(session, window->view().eye()));
  const model::Project guarded = session.project();
  const QPoint point = Hand::pointOf(
      window->view().eye().pixelOf(session.selectedTissue()->curves[0].points[1].at).value());
  hand.drag({point, point + QPoint(20, 10)});
  CHECK(session.project() == guarded);
}

TEST_CASE(
    "a view in motion shows what it shows at rest, with as many pixels as there is time for") {
  auto window = openWindow();
  Hand hand(*window);
  REQUIRE(window->openProject(QString::fromStdString(
      (std::filesystem::path(ECORCHE_SOURCE_DIR) / "examples/arm/arm.ecorche").string())));
  REQUIRE(hand.settle());
  const QImage rest = hand.look();
  Viewport& view = window->view();
  // Turned there and back, so that a slow machine has found its number of pixels
  const QPoint middle(view.width() / 2, view.height() / 2);
  const QPoint aside = middle + QPoint(60, 0);
  hand.drag({middle, aside, middle, aside, middle}, {}, Qt::MiddleButton);
  const QImage moving = view.grabFramebuffer();
  hand.keep("16-moving");
  REQUIRE(moving.size() == rest.size());
  // Averages of blocks: edges are softer, light has no shadows, but it is the same picture
  int far = 0, blocks = 0;
  for (int y = 0; y + 24 <= rest.height(); y += 24)
    for (int x = 0; x + 24 <= rest.width(); x += 24) {
      const auto mean = [&](const QImage& image) {
        Eigen::Vector3d sum = Eigen::Vector3d::Zero();
        for (int j = 0; j < 24; ++j)
          for (int i = 0; i < 24; ++i) {
            const QColor c = image.pixelColor(x + i, y + j);
            sum += Eigen::Vector3d(c.red(), c.green(), c.blue());
          }
        return Eigen::Vector3d(sum / 576.0);
      };
      ++blocks;
      far += (mean(moving) - mean(rest)).norm() > 45.0 ? 1 : 0;
    }
  INFO(far << " of " << blocks << " blocks differ");
  CHECK(far < blocks / 20);
  CHECK(test::changedShare(rest, hand.look()) < 0.001);
}
