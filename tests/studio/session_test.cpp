#include <ecorche/engine/live_parts.h>
#include <ecorche/model/project_file.h>
#include <ecorche/studio/edits.h>
#include <ecorche/studio/kept_surfaces.h>

#include <catch2/catch.hpp>

#include "studio/hand.h"

using namespace ecorche;
using namespace ecorche::studio;
using test::waitFor;

TEST_CASE(
    "tets are refined around muscles when the hand rests, and what is seen stays until then") {
  test::application();
  Session session({.tets = 30'000});
  session.start(test::arm(), {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  const auto coarse = session.tissues();
  int shown = 0;
  bool gone = false;
  auto last = coarse;
  QObject::connect(&session, &Session::liveChanged, [&] {
    gone = gone || !session.tissues();
    shown += session.tissues() != last;
    last = session.tissues();
  });
  session.setRefining(true);
  REQUIRE(waitFor([&] { return session.isSettled() && session.tissues() != coarse; }));
  CHECK_FALSE(gone);
  CHECK(shown == 1);
  const auto fine = session.tissues();
  CHECK(fine->domain != coarse->domain);
  CHECK(fine->domain->domain.mesh.T.rows() < 1.15 * double(coarse->domain->domain.mesh.T.rows()));
  CHECK(session.volumeOf("brachialis").value() > 0.0);

  // Nothing moves: nothing is made again
  REQUIRE(session.perform(model::SetPointValue{"brachialis", 0, 1, 1.1}, "Value"));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.tissues() == fine);
  // A curve goes on: the same tets, until it has left those that are small for it
  REQUIRE(session.perform(model::MoveCurve{"brachialis", 0, {0.0005, 0, 0}}, "Move"));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.tissues()->domain == fine->domain);
}

TEST_CASE("a solve that is given up leaves the tissues at hand for tets to be refined around") {
  test::application();
  for (const int wait : {1, 5, 10, 15, 20, 30, 40}) {
    INFO("undone after " << wait << " ms");
    Session session({.tets = 30'000});
    session.start(test::arm(), {}, true);
    REQUIRE(waitFor([&] { return session.isSettled(); }));
    const auto coarse = session.tissues();
    REQUIRE(session.perform(model::MoveCurve{"brachialis", 0, {0.002, 0, 0}}, "Move"));
    QTest::qWait(wait);
    session.undo();
    session.setRefining(true);
    REQUIRE(waitFor([&] { return session.isSettled() && session.tissues() != coarse; }));
    CHECK(session.tissues()->domain != coarse->domain);
  }
}

TEST_CASE("undo and redo show what had been settled, and solve nothing") {
  test::application();
  Session session({.tets = 30'000});
  session.start(test::arm(), {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  const auto values = [&] { return session.tissues()->fields->fields().values; };
  const tissue::FieldMatrix before = values();
  REQUIRE(session.perform(model::MoveCurve{"brachialis", 0, {0.001, 0, 0}}, "Move"));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK_FALSE(session.tissues()->isKept);
  const tissue::FieldMatrix moved = values();
  CHECK(moved != before);

  session.undo();
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.tissues()->isKept);
  CHECK(values() == before);
  session.redo();
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.tissues()->isKept);
  CHECK(values() == moved);
}

TEST_CASE("only what is computed from counts as changed") {
  const model::Project before = test::arm();
  const auto after = [&](const model::Command& command) {
    return model::apply(before, command).value();
  };
  const auto sameCurves = [&](const model::Project& p) {
    return engine::curvePart(p) == engine::curvePart(before);
  };
  const auto sameDomain = [&](const model::Project& p) {
    return engine::domainPart(p) == engine::domainPart(before);
  };
  const auto sameMeshes = [&](const model::Project& p) {
    return engine::meshPart(p) == engine::meshPart(before);
  };
  // A name, a colour, a layer, a muscle without a curve: nothing
  for (const model::Command& command : std::vector<model::Command>{
           model::RenameTissue{"deltoid", "shoulder"},
           model::SetColour{"deltoid", model::Colour{1, 2, 3}}, model::SetLayer{"deltoid", 7},
           model::SetGroup{"deltoid", "g"}, model::SetSide{"deltoid", model::Side::Right},
           model::RenameCurve{"deltoid", 0, "x"}, model::AddMuscle{"new"},
           model::SetProtected{"deltoid", true}, model::SetKeepsTwin{"deltoid", true},
           model::SetProjectName{"n"}})
    CHECK(sameCurves(after(command)));
  // Values and fat: fields follow without being solved for
  for (const model::Command& command :
       std::vector<model::Command>{model::SetPointValue{"deltoid", 0, 0, 3}, model::SetFat{0.1}})
    CHECK(sameCurves(after(command)));
  // Curves: fields alone
  for (const model::Command& command : std::vector<model::Command>{
           model::MoveCurve{"deltoid", 0, {0.001, 0, 0}}, model::RemoveTissue{"deltoid"},
           model::SetAnisotropy{"biceps_brachii", {2, 1, 0}}}) {
    CHECK_FALSE(sameCurves(after(command)));
    CHECK(sameDomain(after(command)));
  }
  // A plane: the domain, not the meshes
  const auto cut =
      after(model::AddPlane{{"p", model::CutPlane::Kind::Region, {0, 0, 0}, {0, 0, 1}}});
  CHECK_FALSE(sameDomain(cut));
  CHECK(sameMeshes(cut));
  CHECK_FALSE(sameMeshes(after(model::RemoveBone{"hand"})));
}

TEST_CASE("answers belong to the newest question") {
  test::application();
  Session session({.tets = 30'000});
  int domains = 0;
  int tissues = 0;
  std::shared_ptr<const domain::DomainBuild> lastDomain;
  std::shared_ptr<const engine::LiveTissues> lastTissues;
  QObject::connect(&session, &Session::liveChanged, [&] {
    if (session.domain() && session.domain() != lastDomain) ++domains;
    if (session.tissues() && session.tissues() != lastTissues) ++tissues;
    lastDomain = session.domain();
    lastTissues = session.tissues();
  });
  session.start(test::arm(), {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(domains == 1);
  CHECK(tissues == 1);
  const double before = session.volumeOf("biceps_brachii").value();

  // A rename: the volume is known at once under the new name, and nothing is computed
  REQUIRE(session.perform(model::RenameTissue{"biceps_brachii", "biceps"}, "Rename"));
  CHECK(session.volumeOf("biceps") == before);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(tissues == 1);

  // Values: the fields are those of a solve from scratch, and nothing was solved
  for (int k = 1; k <= 40; ++k)
    REQUIRE(session.perform(model::SetPointValue{"biceps", 0, 1, 1.0 + 0.05 * k}, "Value"));
  REQUIRE(session.perform(model::SetFat{0.4}, "Fat"));
  const auto edited = session.tissues()->fields;
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(tissues == 1);
  const double thick = session.volumeOf("biceps").value();
  CHECK(thick > before);
  session.reloadMeshes();
  REQUIRE(waitFor([&] { return session.isSettled() && session.tissues()->fields != edited; }));
  CHECK(
      (session.tissues()->fields->fields().values - edited->fields().values).cwiseAbs().maxCoeff() <
      1e-10 * edited->fields().maxValue);
  CHECK(session.volumeOf("biceps").value() == Approx(thick).epsilon(1e-9));

  // Many moves in a row: the last one is what is seen, and few of the others were ever computed
  tissues = 0;
  domains = 0;
  for (int k = 1; k <= 40; ++k)
    REQUIRE(session.perform(model::MoveCurve{"biceps", 0, {0.0001, 0, 0}}, "Move"));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(tissues > 0);
  CHECK(tissues < 12);
  CHECK(domains == 0);

  // Undone: the same as before
  session.goToStep(0);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.volumeOf("biceps_brachii").value() == Approx(before).epsilon(1e-9));
}

TEST_CASE("a muscle whose curve leaves the skin is told, and the others stay") {
  test::application();
  Session session({.tets = 30'000});
  std::vector<std::string> told;
  QObject::connect(&session, &Session::told, [&](Severity severity, const QString& text) {
    if (severity == Severity::Error) told.push_back(text.toStdString());
  });
  session.start(test::arm(), {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(told.empty());
  REQUIRE(session.perform(model::MovePoint{"biceps_brachii", 0, 1, {1.0, 1.0, 1.0}}, "Away"));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  REQUIRE(told.size() == 1);
  CHECK_THAT(told[0], Catch::Contains("biceps_brachii") && Catch::Contains("leaves the skin"));
  CHECK_FALSE(session.volumeOf("biceps_brachii"));
  CHECK(session.volumeOf("brachialis").value_or(0.0) > 0.0);
}

TEST_CASE("a draft is seen, and is no step until it is kept") {
  test::application();
  Session session({.tets = 30'000});
  session.start(test::arm(), {}, true);
  const model::Project before = session.project();
  const model::Command thin = model::SetPointValue{"deltoid", 0, 0, 0.5};
  const model::Command thick = model::SetPointValue{"deltoid", 0, 0, 2.5};
  REQUIRE(session.draft({thin}));
  CHECK(session.project().tissues[0].curves[0].points[0].tissue == 0.5);
  CHECK(session.history().project() == before);
  REQUIRE(session.draft({thick}));
  REQUIRE(session.keepDraft("Thick"));
  CHECK(session.history().stepsDone() == 1);
  CHECK(session.project().tissues[0].curves[0].points[0].tissue == 2.5);
  REQUIRE(session.draft({thin}));
  session.dropDraft();
  CHECK(session.project().tissues[0].curves[0].points[0].tissue == 2.5);
  // What cannot be done leaves everything as it was
  CHECK_FALSE(session.draft({model::SetPointValue{"deltoid", 0, 0, -1.0}}));
  CHECK_FALSE(session.perform(model::RenameTissue{"deltoid", "biceps_brachii"}, "Rename"));
  CHECK(session.history().stepsDone() == 1);
  session.undo();
  CHECK(session.project() == before);
  CHECK(session.isSaved());
}

TEST_CASE("what cut planes take away is neither shown nor under the hand") {
  test::application();
  Session session({.tets = 30'000});
  session.start(test::arm(), {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  const auto whole = keptSurfaces(session.meshes(), {}, session.domain());
  CHECK_FALSE(whole.resampled);
  CHECK(whole.bones.size() == 6);

  const mesh::Box box = mesh::boundingBox(session.meshes()->meshes.skin);
  int axis = 0;
  (box.hi - box.lo).maxCoeff(&axis);
  const model::CutPlane plane{"edge", model::CutPlane::Kind::Region, 0.5 * (box.lo + box.hi),
                              mesh::Vector3::Unit(axis)};
  model::Project half = test::arm();
  std::erase_if(half.tissues, [](const model::Tissue& t) { return t.hasCurves(); });
  half.cutPlanes.push_back(plane);
  session.start(half, {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  REQUIRE(session.domain());
  const auto kept = keptSurfaces(session.meshes(), half.cutPlanes, session.domain());
  CHECK(kept.resampled);
  CHECK(kept.bones.size() < 6);
  CHECK_FALSE(kept.bones.empty());
  const double tolerance = 0.002 * session.meshes()->diagonal;
  const auto lowest = [&](const mesh::SurfaceMesh& m) {
    return ((m.V.rowwise() - plane.point.transpose()) * plane.normal).minCoeff();
  };
  CHECK(lowest(*kept.skin) > -tolerance);
  CHECK(kept.skin->F.rows() > 100);
  for (const auto& bone : kept.bones) CHECK(lowest(*bone) > -tolerance);

  // Rays that meet bone on the lost side alone meet none
  int met = 0;
  int lost = 0;
  for (const auto& bone : session.meshes()->meshes.bones) {
    for (Eigen::Index v = 0; v < bone.V.rows(); v += 7) {
      const mesh::Vector3 p = bone.V.row(v).transpose();
      const mesh::Vector3 across = mesh::Vector3::Unit((axis + 1) % 3);
      const auto hit = boneUnder({p - 2.0 * across, across}, *session.meshes(), half, {});
      if ((p - plane.point).dot(plane.normal) < 0.0) {
        ++lost;
        CHECK_FALSE(hit);
      } else {
        met += hit.has_value();
      }
    }
  }
  CHECK(met > 20);
  CHECK(lost > 20);
}

TEST_CASE("a muscle gets the volume that is asked for, as one step") {
  test::application();
  Session session({.tets = 30'000});
  session.start(test::arm(), {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  const model::Project before = session.project();
  REQUIRE(session.setVolume("brachialis", 150e-6));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK(session.volumeOf("brachialis").value() == Approx(150e-6).epsilon(2e-3));
  CHECK(session.history().stepsDone() == 1);
  QString told;
  QObject::connect(&session, &Session::told, [&](Severity, const QString& text) { told = text; });
  CHECK_FALSE(session.setVolume("brachialis", 1.0));
  CHECK_THAT(told.toStdString(), Catch::Contains("brachialis") && Catch::Contains("cm³"));
  session.undo();
  CHECK(session.project() == before);
}

TEST_CASE("fields follow a curve under the hand, and are exact once it rests") {
  test::application();
  // With a spread of its own as without
  const double lambda3 = GENERATE(1.0, 0.6);
  INFO("lambda 3: " << lambda3);
  Session session({.tets = 30'000});
  model::Project project = test::arm();
  project.tissues[*model::findTissue(project, "brachialis")].anisotropy.lambda3 = lambda3;
  session.start(std::move(project), {}, true);
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  const auto before = session.tissues();
  const auto& all = before->fields->tissues();
  const auto column =
      std::ranges::find(all, "brachialis", &tissue::CurveTissue::name) - all.begin() + 1;
  const Eigen::VectorXd f = before->fields->fields().values.col(column);
  const mesh::Vector3 from = session.project()
                                 .tissues[*model::findTissue(session.project(), "brachialis")]
                                 .curves[0]
                                 .points[1]
                                 .at;
  int told = 0;
  QObject::connect(&session, &Session::fieldsChanged, [&] { ++told; });
  Eigen::VectorXd dragged;
  for (int frame = 1; frame <= 5; ++frame) {
    REQUIRE(session.draft(
        {model::MovePoint{"brachialis", 0, 1, from + frame * mesh::Vector3(0.002, 0.001, 0.0)}}));
    // At once: the window's thread has not waited for anybody
    CHECK(told == frame);
    CHECK(session.tissues() == before);
    CHECK(before->fields->isAdrift());
    dragged = before->fields->fields().values.col(column);
    CHECK((dragged - f).cwiseAbs().maxCoeff() > 0.02);
    const auto edits = session.takeFieldEdits();
    REQUIRE(edits.changed);
    CHECK(std::ranges::count(edits.changed->columns, static_cast<std::int32_t>(column)) == 1);
  }
  // A value that is edited before that waits for it; a volume asks for patience
  CHECK_FALSE(session.setVolume("brachialis", 150e-6));
  REQUIRE(session.keepDraft("Move"));
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  REQUIRE(session.tissues() != before);
  CHECK_FALSE(session.tissues()->fields->isAdrift());
  // Tets may be others by now; without new ones what was seen was near
  if (session.tissues()->domain == before->domain) {
    const auto& settled = session.tissues()->fields->fields();
    CHECK((settled.values.col(column) - dragged).cwiseAbs().maxCoeff() < 0.03 * settled.maxValue);
  }
  session.undo();
  CHECK(session.tissues()->fields->isAdrift());
  REQUIRE(waitFor([&] { return session.isSettled(); }));
  CHECK_FALSE(session.tissues()->fields->isAdrift());
  REQUIRE(session.setVolume("brachialis", 150e-6));
}

TEST_CASE("acts on what is selected") {
  test::application();
  Session session({.tets = 30'000});
  session.start(test::arm(), {}, true);
  const auto tissue = [&](const std::string& name) {
    return session.project().tissues[model::findTissue(session.project(), name).value()];
  };
  QString told;
  QObject::connect(&session, &Session::told, [&](Severity, const QString& text) { told = text; });
  const auto carryOut = [&](const Edit& edit) {
    REQUIRE_FALSE(edit.commands.empty());
    INFO(edit.label.toStdString());
    const bool done = session.perform(edit.commands, edit.label);
    INFO(told.toStdString());
    REQUIRE(done);
    session.select(edit.select);
  };
  const model::Curve head = tissue("biceps_brachii").curves[0];
  const std::size_t heads = tissue("biceps_brachii").curves.size();

  session.select({"biceps_brachii", 0, 1, {}});
  carryOut(splitCurve(session));
  CHECK(tissue("biceps_brachii").curves.size() == heads + 1);
  CHECK(tissue("biceps_brachii").curves[0].points.back() == head.points[1]);
  CHECK(tissue("biceps_brachii").curves.back().points.front() == head.points[1]);
  CHECK(tissue("biceps_brachii").curves.back().end == head.end);
  session.undo();

  session.select({"biceps_brachii", 0, -1, {}});
  const mesh::Spline before = model::splineOf(head);
  const mesh::Vector3 near = before.at(0.5 * before.lastParameter() + 0.3);
  carryOut(insertPoint(session, near));
  const model::Curve more = tissue("biceps_brachii").curves[0];
  CHECK(more.points.size() == head.points.size() + 1);
  const auto added = static_cast<std::size_t>(session.selection().point);
  CHECK((more.points[added].at - near).norm() < 0.01 * before.length());
  carryOut(removeSelected(session));
  CHECK(tissue("biceps_brachii").curves[0] == head);

  session.select({"biceps_brachii", -1, -1, {}});
  carryOut(thicken(session, 2.0));
  CHECK(tissue("biceps_brachii").curves[0].points[0].tissue == 2.0 * head.points[0].tissue);
  carryOut(duplicate(session));
  CHECK(session.selection().tissue == "biceps_brachii 2");
  CHECK(tissue("biceps_brachii 2").curves == tissue("biceps_brachii").curves);
  carryOut(removeSelected(session));
  CHECK_FALSE(model::findTissue(session.project(), "biceps_brachii 2"));

  // Mirrored twice across one plane it is where it was
  REQUIRE(waitFor([&] { return session.meshes() != nullptr; }));
  const MirrorPlane plane{{0.0, 0.0, 0.0}, mesh::Vector3::UnitX()};
  session.select({"supinator", -1, -1, {}});
  const auto original = tissue("supinator");
  carryOut(mirrored(session, plane));
  const std::string first = session.selection().tissue;
  const std::string other = first == "supinator_L" ? "supinator_R" : "supinator_L";
  const auto image = tissue(other);
  REQUIRE(image.curves.size() == original.curves.size());
  for (std::size_t p = 1; p + 1 < image.curves[0].points.size(); ++p) {
    mesh::Vector3 back = image.curves[0].points[p].at;
    back.x() = -back.x();
    CHECK((back - original.curves[0].points[p].at).norm() < 1e-12);
  }
  CHECK(image.side != original.side);
}
