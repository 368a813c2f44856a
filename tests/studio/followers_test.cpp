// What follows an edit within its step: twins that are kept in step, volumes that are kept.

#include <ecorche/model/project_file.h>
#include <ecorche/studio/edits.h>
#include <ecorche/studio/muscle_list.h>

#include <catch2/catch.hpp>

#include "studio/hand.h"

using namespace ecorche;
using namespace ecorche::studio;
using mesh::Vector3;
using test::waitFor;

namespace {

const MirrorPlane kAcrossX{{0.0, 0.0, 0.0}, Vector3::UnitX()};

// A left muscle off the plane, its ends free, so that no bone pulls them
model::Project twoSided() {
  model::Project out = test::arm();
  model::Tissue left{.name = "flexor_L", .side = model::Side::Left};
  left.anisotropy = {2.0, 0.5, 0.3};
  left.curves.push_back(
      {{}, {{{0.1, 0.0, 0.0}, 1.0}, {{0.2, 0.1, 0.4}, 1.2}, {{0.1, 0.0, 0.9}, 0.8}}, {}, {}});
  out.tissues = {left, {.name = "flexor_R", .side = model::Side::Right}, {.name = "lonely"}};
  out.tissues[1].curves = left.curves;
  out.tissues[2].curves = left.curves;
  return out;
}

model::Project after(model::Project project, const std::vector<model::Command>& commands) {
  for (const model::Command& command : commands) project = model::apply(project, command).value();
  return project;
}

const model::Tissue& tissueOf(const model::Project& project, const std::string& name) {
  return project.tissues[model::findTissue(project, name).value()];
}

bool isImage(const model::Tissue& a, const model::Tissue& b) {
  if (a.curves.size() != b.curves.size()) return false;
  for (std::size_t c = 0; c < a.curves.size(); ++c) {
    if (a.curves[c].points.size() != b.curves[c].points.size()) return false;
    for (std::size_t p = 0; p < a.curves[c].points.size(); ++p) {
      const auto& from = a.curves[c].points[p];
      const auto& to = b.curves[c].points[p];
      if (kAcrossX.image(from.at) != to.at || from.tissue != to.tissue) return false;
    }
  }
  return a.anisotropy.lambda2 == b.anisotropy.lambda2 &&
         a.anisotropy.rotation == -b.anisotropy.rotation && a.group == b.group;
}

}  // namespace

TEST_CASE("a twin that is kept in step follows whatever is done to the muscle") {
  const model::Project before = after(twoSided(), {model::SetKeepsTwin{"flexor_L", true}});
  for (const model::Command& command : std::vector<model::Command>{
           model::MovePoint{"flexor_L", 0, 1, {0.3, 0.2, 0.5}},
           model::SetPointValue{"flexor_L", 0, 2, 3.0}, model::RemovePoint{"flexor_L", 0, 1},
           model::AddCurve{"flexor_L", twoSided().tissues[0].curves[0]},
           model::SetAnisotropy{"flexor_L", {3.0, 1.0, -0.7}},
           model::SetGroup{"flexor_L", "forearm"}}) {
    const model::Project edited = after(before, {command});
    const auto follow = twinsFollow(before, edited, nullptr, kAcrossX);
    const model::Project whole = after(edited, follow);
    CHECK(isImage(tissueOf(whole, "flexor_L"), tissueOf(whole, "flexor_R")));
    CHECK(tissueOf(whole, "flexor_R").keepsTwin);
    CHECK(tissueOf(whole, "lonely") == tissueOf(before, "lonely"));
    // In step, nothing is left to do, and an edit of the other side comes back
    CHECK(twinsFollow(edited, whole, nullptr, kAcrossX).empty());
    const model::Project other = after(whole, {model::MoveCurve{"flexor_R", 0, {0.0, 0.1, 0.0}}});
    const model::Project back = after(other, twinsFollow(whole, other, nullptr, kAcrossX));
    CHECK(isImage(tissueOf(back, "flexor_R"), tissueOf(back, "flexor_L")));
  }
  // Those that are not kept, and those without a side, stay alone
  const model::Project free = after(twoSided(), {model::MoveCurve{"flexor_L", 0, {0, 0.1, 0}}});
  CHECK(twinsFollow(twoSided(), free, nullptr, kAcrossX).empty());
}

TEST_CASE("a twin that is not there yet comes when it is asked to follow") {
  model::Project before = twoSided();
  before.tissues.erase(before.tissues.begin() + 1);
  const model::Project on = after(before, {model::SetKeepsTwin{"flexor_L", true}});
  const model::Project whole = after(on, twinsFollow(before, on, nullptr, kAcrossX));
  CHECK(tissueOf(whole, "flexor_R").side == model::Side::Right);
  CHECK(isImage(tissueOf(whole, "flexor_L"), tissueOf(whole, "flexor_R")));
}

TEST_CASE("an edit and what follows it are one step, renames too; a protected twin bars it") {
  test::application();
  Session session({.tets = 30'000});
  model::Project project = test::arm();
  project.cutPlanes.push_back(
      {"median", model::CutPlane::Kind::Symmetry, {0.0, 0.0, -10.0}, Vector3::UnitZ()});
  session.start(project, {}, true);
  REQUIRE(session.perform(model::RenameTissue{"supinator", "supinator_L"}, "rename"));
  REQUIRE(session.perform(model::SetKeepsTwin{"supinator_L", true}, "keep"));
  REQUIRE(model::findTissue(session.project(), "supinator_R"));
  const model::Project before = session.project();
  const auto points = [&](const std::string& name) {
    return tissueOf(session.project(), name).curves[0].points;
  };
  session.draft({model::SetPointValue{"supinator_L", 0, 1, 2.5}});
  CHECK(points("supinator_R")[1].tissue == 2.5);
  REQUIRE(session.keepDraft("value"));
  CHECK(points("supinator_R")[1].tissue == 2.5);
  session.undo();
  CHECK(session.project() == before);
  session.redo();
  CHECK(points("supinator_R")[1].tissue == 2.5);
  REQUIRE(session.perform(model::RenameTissue{"supinator_L", "turner_L"}, "rename"));
  CHECK(model::findTissue(session.project(), "turner_R"));
  CHECK_FALSE(model::findTissue(session.project(), "supinator_R"));

  REQUIRE(session.perform(model::SetProtected{"turner_R", true}, "protect"));
  QString told;
  QObject::connect(&session, &Session::told, [&](Severity, const QString& text) { told = text; });
  const model::Project guarded = session.project();
  CHECK_FALSE(session.perform(model::SetPointValue{"turner_L", 0, 1, 3.0}, "value"));
  CHECK_THAT(told.toStdString(), Catch::Contains("turner_R") && Catch::Contains("protected"));
  CHECK(session.project() == guarded);
}

TEST_CASE("a volume that is kept stays while values and points change, within the same step") {
  test::application();
  Session session({.tets = 30'000});
  session.start(test::arm(), {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  const double volume = session.volumeOf("brachialis").value();
  session.keepVolume("brachialis", true);
  const model::Project before = session.project();
  const double value = before.tissues[8].curves[0].points[1].tissue;
  REQUIRE(before.tissues[8].name == "brachialis");
  REQUIRE(session.perform(model::SetPointValue{"brachialis", 0, 1, 1.6 * value}, "value"));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.volumeOf("brachialis").value() == Approx(volume).epsilon(4e-3));
  const auto& points = session.project().tissues[8].curves[0].points;
  // Thicker there, thinner elsewhere: the shape that was asked for at the size that was kept
  CHECK(points[1].tissue / points[0].tissue ==
        Approx(1.6 * value / before.tissues[8].curves[0].points[0].tissue));
  CHECK(session.history().stepsDone() == 1);
  REQUIRE(session.perform(
      model::MovePoint{"brachialis", 0, 1, points[1].at + Vector3(0.0, 0.003, 0.0)}, "move"));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.volumeOf("brachialis").value() == Approx(volume).epsilon(4e-3));
  CHECK(session.history().stepsDone() == 2);
  session.undo();
  session.undo();
  CHECK(session.project() == before);
  session.keepVolume("brachialis", false);
  REQUIRE(session.perform(model::SetPointValue{"brachialis", 0, 1, 1.6 * value}, "value"));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.volumeOf("brachialis").value() > 1.02 * volume);
}

TEST_CASE("directions of fibres come when somebody looks at them, unit or none") {
  test::application();
  Session session({.tets = 30'000});
  session.start(test::arm(), {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.flow() == nullptr);
  studio::Display display = session.display();
  display.fibers = true;
  session.setDisplay(display);
  REQUIRE(waitFor([&] { return session.flow() != nullptr; }));
  const auto& owners = session.tissues()->fields->owners();
  for (Eigen::Index v = 0; v < session.flow()->rows(); ++v) {
    const bool muscle = owners[static_cast<std::size_t>(v)].value >= kFirstMuscle.value;
    CHECK(session.flow()->row(v).norm() == Approx(muscle ? 1.0 : 0.0).margin(1e-12));
  }
}

TEST_CASE("muscles of a group stand under its name, hidden and shown together") {
  test::application();
  Session session({.tets = 30'000});
  MuscleList list(session, [](std::size_t) { return QColor(Qt::red); });
  session.start(test::arm(), {}, true);
  for (const char* name : {"anconeus", "brachialis", "triceps_brachii"})
    REQUIRE(session.perform(model::SetGroup{name, "levers"}, "group"));
  QTreeWidgetItem* group = nullptr;
  int muscles = 0;
  for (int i = 0; i < list.topLevelItemCount(); ++i) {
    QTreeWidgetItem* item = list.topLevelItem(i);
    muscles += std::max(1, item->childCount());
    if (item->text(1) == "levers") group = item;
  }
  CHECK(muscles == std::ssize(session.project().tissues));
  REQUIRE(group != nullptr);
  CHECK(group->childCount() == 3);
  Q_EMIT list.itemClicked(group, 0);
  for (const char* name : {"anconeus", "brachialis", "triceps_brachii"})
    CHECK_FALSE(session.display().showsTissue(name));
  CHECK(session.display().showsTissue("deltoid"));
  Q_EMIT list.itemClicked(group, 0);
  CHECK(session.display().showsTissue("brachialis"));
  Q_EMIT list.itemClicked(group->child(1), 1);
  CHECK(session.selection().tissue == group->child(1)->text(1).toStdString());
}
