// A hand without a plan: whatever it does, the project stays sound, and its past leads back and
// forth.

#include <ecorche/model/project_check.h>
#include <ecorche/model/project_file.h>

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QSlider>
#include <QTreeWidget>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <random>

#include "studio/hand.h"

using namespace ecorche;
using namespace ecorche::studio;
using test::Hand;

namespace {

class Monkey {
 public:
  Monkey(MainWindow& window, std::uint64_t seed) : window_(window), hand_(window), random_(seed) {}

  void act() {
    switch (below(9)) {
      case 0:
        return selectSomething();
      case 1:
        return drag();
      case 2:
        return drag(Qt::ShiftModifier);
      case 3:
        return drag(Qt::ControlModifier);
      case 4:
        return dragPoint();
      case 5:
        return slide();
      case 6:
        return tick();
      default:
        return trigger();
    }
  }

 private:
  MainWindow& window_;
  Hand hand_;
  std::mt19937_64 random_;

  int below(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  Session& session() { return window_.session(); }
  QPoint anywhere() { return {below(window_.view().width()), below(window_.view().height())}; }

  void selectSomething() {
    const auto& tissues = session().project().tissues;
    if (tissues.empty()) return;
    const auto& tissue = tissues[static_cast<std::size_t>(below(static_cast<int>(tissues.size())))];
    Selection s{tissue.name, -1, -1, {}};
    if (!tissue.curves.empty() && below(3) > 0) {
      s.curve = below(static_cast<int>(tissue.curves.size()));
      if (below(2) == 0)
        s.point =
            below(static_cast<int>(tissue.curves[static_cast<std::size_t>(s.curve)].points.size()));
    }
    session().select(s);
  }
  void drag(Qt::KeyboardModifiers modifiers = Qt::NoModifier) {
    hand_.drag({anywhere(), anywhere()}, modifiers);
  }
  void dragPoint() {
    const model::Tissue* tissue = session().selectedTissue();
    if (tissue == nullptr || tissue->curves.empty()) return;
    const auto& points = tissue->curves.front().points;
    const auto seen = window_.view().eye().pixelOf(
        points[static_cast<std::size_t>(below(static_cast<int>(points.size())))].at);
    if (!seen) return;
    const QPoint at = Hand::pointOf(*seen);
    hand_.drag({at, at + QPoint(below(61) - 30, below(61) - 30)});
  }
  template <class Widget>
  Widget* any() {
    QList<Widget*> all;
    for (Widget* w : window_.findChildren<Widget*>())
      if (w->isVisible() && w->isEnabled()) all.push_back(w);
    return all.isEmpty() ? nullptr : all[below(static_cast<int>(all.size()))];
  }
  void slide() {
    if (below(2) == 0) {
      if (auto* box = any<QDoubleSpinBox>())
        box->setValue(box->value() * (0.6 + 0.01 * below(100)) + 0.01);
    } else if (auto* slider = any<QSlider>()) {
      slider->setSliderDown(true);
      for (int k = 0; k < 3; ++k)
        slider->setValue(slider->minimum() + below(slider->maximum() - slider->minimum() + 1));
      slider->setSliderDown(false);
    }
  }
  void tick() {
    if (below(2) == 0) {
      if (auto* box = any<QCheckBox>()) box->click();
    } else if (auto* box = any<QComboBox>()) {
      box->setCurrentIndex(below(box->count()));
      Q_EMIT box->activated(box->currentIndex());
    }
  }
  void trigger() {
    static const char* const kActs[] = {
        "undo",     "redo",    "delete",   "duplicate", "mirror",       "split",         "thicker",
        "thinner",  "protect", "hide",     "solo",      "xray",         "showAll",       "spread",
        "select",   "draw",    "drawHead", "click",     "endsOnPlanes", "endsOnMuscles", "frame",
        "frameAll", "front",   "side",     "top",       "parallel"};
    window_.act(kActs[below(static_cast<int>(std::size(kActs)))])->trigger();
  }
};

}  // namespace

TEST_CASE("a hand without a plan leaves a sound project and a past that leads back") {
  // A seed a run; ECORCHE_SEED chooses another
  const char* chosen = std::getenv("ECORCHE_SEED");
  const std::uint64_t seed = chosen != nullptr ? std::strtoull(chosen, nullptr, 10) : 1;
  INFO("seed " << seed << ": repeat with ECORCHE_SEED=" << seed);
  test::application();
  MainWindow window({.tets = 20'000});
  window.resize(1000, 700);
  window.show();
  REQUIRE(QTest::qWaitForWindowExposed(&window));
  Session& session = window.session();
  REQUIRE(window.openProject(QString::fromStdString(
      (std::filesystem::path(ECORCHE_SOURCE_DIR) / "examples/arm/arm.ecorche").string())));
  REQUIRE(test::waitFor([&] { return session.tissues() != nullptr; }));
  const model::Project begin = session.project();

  Monkey monkey(window, seed);
  for (int k = 0; k < 60; ++k) {
    monkey.act();
    QTest::qWait(k % 10 == 0 ? 60 : 1);
    const auto fault = model::findFault(session.project(), model::Completeness::Editing);
    if (fault) INFO(fault->message);
    REQUIRE_FALSE(fault);
  }
  session.dropDraft();
  const std::size_t steps = session.history().stepsDone();
  CHECK(steps > 5);
  const model::Project end = session.project();
  session.goToStep(0);
  CHECK(session.project() == begin);
  session.goToStep(steps);
  CHECK(session.project() == end);
  REQUIRE(test::waitFor([&] { return session.isSettled(); }, 180));
  // Complete ones can be saved and read
  if (!model::findFault(end, model::Completeness::Complete))
    CHECK(model::parseProject(model::projectText(end), begin.folder / "x.ecorche").value() == end);
}
