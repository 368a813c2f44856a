// From a hand's movement to the picture that shows it, in a real window:
//   xvfb-run bench_studio PROJECT [--tets N] [--size N] [--json]
// while nothing is computed, while a moved curve is being solved for, and for a tissue value.
#include <ecorche/engine/machine.h>
#include <ecorche/model/project_file.h>
#include <ecorche/studio/session.h>
#include <ecorche/studio/viewport.h>
#include <fmt/format.h>

#include <QApplication>
#include <QElapsedTimer>
#include <QMouseEvent>
#include <QSurfaceFormat>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

using namespace ecorche;
using namespace ecorche::studio;

namespace {

double quantile(std::vector<double> ms, double q) {
  if (ms.empty()) return 0.0;
  std::ranges::sort(ms);
  return ms[static_cast<std::size_t>(std::ceil(q * static_cast<double>(ms.size() - 1)))];
}

class Bench {
 public:
  Bench(Session& session, Viewport& view) : session_(session), view_(view) {
    QObject::connect(&view_, &Viewport::drawn, [this] { ++drawn_; });
  }

  void settle() {
    while (!session_.isSettled()) QApplication::processEvents(QEventLoop::WaitForMoreEvents, 50);
  }

  // Acts, and handles events until the next picture is there [ms]
  template <class Act>
  double untilDrawn(const Act& act) {
    QElapsedTimer clock;
    clock.start();
    const int before = drawn_;
    act();
    acted_ = static_cast<double>(clock.nsecsElapsed()) * 1e-6;
    while (drawn_ == before) QApplication::processEvents(QEventLoop::AllEvents, 5);
    return static_cast<double>(clock.nsecsElapsed()) * 1e-6;
  }

  // How long the last act took, until it had been carried out [ms]
  [[nodiscard]] double acted() const { return acted_; }

  double turn() {
    return untilDrawn([&] {
      const QPointF at(20.0 + 10.0 * (step_ % 2), 30.0);
      ++step_;
      send(QEvent::MouseMove, at, Qt::NoButton, Qt::MiddleButton);
    });
  }
  void grab() { send(QEvent::MouseButtonPress, {20, 30}, Qt::MiddleButton, Qt::MiddleButton); }
  void letGo() { send(QEvent::MouseButtonRelease, {20, 30}, Qt::MiddleButton, Qt::NoButton); }

 private:
  Session& session_;
  Viewport& view_;
  int drawn_ = 0;
  double acted_ = 0.0;
  int step_ = 0;

  void send(QEvent::Type type, const QPointF& at, Qt::MouseButton button, Qt::MouseButtons held) {
    QMouseEvent event(type, at, view_.mapToGlobal(at), button, held, Qt::NoModifier);
    QApplication::sendEvent(&view_, &event);
  }
};

}  // namespace

int main(int argc, char** argv) {
  QSurfaceFormat format;
  format.setVersion(3, 3);
  format.setProfile(QSurfaceFormat::CoreProfile);
  QSurfaceFormat::setDefaultFormat(format);
  QApplication app(argc, argv);
  std::string file;
  std::int64_t tets = 640'000;
  int size = 64;
  bool json = false;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--json") == 0) {
      json = true;
    } else if (std::strcmp(argv[i], "--tets") == 0 && i + 1 < argc) {
      const std::string text = argv[++i];
      tets = std::stoll(text) * (text.ends_with("k") ? 1000 : 1);
    } else if (std::strcmp(argv[i], "--size") == 0 && i + 1 < argc) {
      size = std::stoi(argv[++i]);
    } else {
      file = argv[i];
    }
  }
  auto project = model::loadProject(file);
  if (!project) {
    fmt::print(stderr, "bench_studio: {}\n", project.error().text());
    return 1;
  }
  project->settings.edgeLength.reset();
  project->settings.tets = tets;

  Session session({.tets = tets});
  Viewport view(session);
  view.resize(size, size);
  view.show();
  std::string told;
  QObject::connect(&session, &Session::told,
                   [&](Severity, const QString& text) { told += "\n  " + text.toStdString(); });
  session.start(std::move(*project), {}, true);
  Bench bench(session, view);
  bench.settle();
  if (!session.tissues()) {
    fmt::print(stderr, "bench_studio: the project cannot be solved{}\n", told);
    return 1;
  }
  const std::string muscle = session.project().tissues[0].name;

  std::vector<double> still, solving, drags, dragged, values;
  bench.grab();
  for (int k = 0; k < 200; ++k) still.push_back(bench.turn());
  // A moved curve: turned all the while, until its answer is there
  int solves = 0;
  while (solving.size() < 200 && solves < 20) {
    session.perform(model::MoveCurve{muscle, 0, {0.0005, 0.0, 0.0}}, "move");
    while (!session.isSettled()) solving.push_back(bench.turn());
    ++solves;
  }
  bench.letGo();
  bench.settle();
  // A control point under the hand, half a millimetre a frame
  const auto& points = session.project().tissues[0].curves[0].points;
  const std::size_t inner = points.size() / 2;
  const mesh::Vector3 from = points[inner].at;
  for (int k = 0; k < 200; ++k) {
    const double way = k < 100 ? 0.0005 * (k + 1) : 0.0005 * (200 - k);
    drags.push_back(bench.untilDrawn([&] {
      session.draft({model::MovePoint{muscle, 0, inner, from + mesh::Vector3(way, 0.0, 0.0)}});
    }));
    dragged.push_back(bench.acted());
  }
  session.dropDraft();
  bench.settle();
  const double value = session.project().tissues[0].curves[0].points[1].tissue;
  for (int k = 0; k < 200; ++k) {
    values.push_back(bench.untilDrawn([&] {
      session.draft({model::SetPointValue{muscle, 0, 1, value * (1.0 + 0.002 * (k + 1))}});
    }));
  }

  const auto& domain = session.tissues()->domain->domain;
  const auto machine = engine::thisMachine();
  nlohmann::ordered_json out = {{"bench", "studio"},
                                {"machine",
                                 {{"processor", machine.processor},
                                  {"cores", machine.cores},
                                  {"threads", machine.threads},
                                  {"blas", machine.blas}}},
                                {"cases", nlohmann::ordered_json::array()}};
  const auto add = [&](const char* name, const std::vector<double>& ms) {
    out["cases"].push_back({{"name", name},
                            {"tets", domain.mesh.T.rows()},
                            {"muscles", session.project().tissues.size()},
                            {"threads", machine.threads},
                            {"metrics",
                             {{"frames", ms.size()},
                              {"viewport", size},
                              {"p50_ms", quantile(ms, 0.5)},
                              {"p95_ms", quantile(ms, 0.95)},
                              {"max_ms", quantile(ms, 1.0)}}},
                            {"ratios", nlohmann::ordered_json::object()},
                            {"errors", nlohmann::ordered_json::object()}});
    if (!json)
      fmt::print("{:<28} {:>5} frames  p50 {:6.1f}  p95 {:6.1f}  max {:6.1f} ms\n", name, ms.size(),
                 quantile(ms, 0.5), quantile(ms, 0.95), quantile(ms, 1.0));
  };
  if (!json)
    fmt::print("{} tets, {} tissues, {}×{} pixels\n", domain.mesh.T.rows(),
               session.project().tissues.size(), size, size);
  add("turning the view", still);
  add("turning it while solving", solving);
  add("a control point", drags);
  add("… until fields are there", dragged);
  add("a tissue value", values);
  if (json) fmt::print("{}\n", out.dump(2));
  return 0;
}
