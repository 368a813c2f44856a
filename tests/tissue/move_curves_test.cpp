#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/moved_fields.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/settling.h>
#include <ecorche/tissue/tube_sweeps.h>
#include <ecorche/tissue/value_fields.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "support/generated_domain.h"
#include "tissue/curves.h"

using namespace ecorche;
using namespace ecorche::tissue;
using mesh::Vector3;
using test::muscle;

namespace {

std::vector<CurveTissue> fourMuscles() {
  CurveTissue biceps = muscle("biceps", {{0.5, 0.1, 0.1}, {0.6, 0.0, 1.0}, {0.4, -0.1, 1.9}}, 1.2);
  biceps.curves.push_back(
      muscle("", {{0.3, 0.4, 0.1}, {0.45, 0.3, 1.0}, {0.4, 0.0, 1.8}}).curves[0]);
  return {biceps, muscle("a", {{0.1, 0.6, 0.2}, {0.0, 0.6, 1.0}, {0.0, 0.6, 1.8}}),
          muscle("b", {{-0.3, 0.5, 0.2}, {-0.2, 0.3, 1.0}, {-0.3, 0.4, 1.8}}, 0.7),
          muscle("c", {{0.4, -0.5, 0.2}, {0.4, -0.6, 1.8}}, 0.8)};
}

// A domain with curves in it, and what it takes to solve them anew
struct Scene {
  std::shared_ptr<const domain::Domain> domain;
  std::vector<CurveTissue> list = fourMuscles();
  TissueOptions options;
  std::shared_ptr<const TissueSolver> solver;
  std::shared_ptr<const CurveWalker> walker;
  RunContext run;

  explicit Scene(int resolution = 16)
      : domain(std::make_shared<const domain::Domain>(
            test::cylinderDomain(1.0, 2.0, resolution, resolution))),
        walker(std::make_shared<const CurveWalker>(*domain)) {
    options.fat = 0.3;
    solver =
        std::make_shared<const TissueSolver>(std::move(TissueSolver::create(*domain, run).value()));
  }
  ValueFields settled() {
    return ValueFields::create(domain, solver,
                               traceCurves(*walker, *domain, list, options, run).value(), list,
                               options, run, walker)
        .value();
  }
  // With the equations of anisotropic fields, so that they follow
  ValueFields settledToFollow() {
    Settling settling(solver);
    return ValueFields::create(domain, settling,
                               traceCurves(*walker, *domain, list, options, run).value(), list,
                               options, run, walker)
        .value();
  }
  TissueFields anew(const std::vector<CurveTissue>& moved) {
    return solver
        ->solve(traceCurves(*walker, *domain, moved, options, run).value(), moved, options, run)
        .value();
  }
};

double off(const ValueFields& dragged, const TissueFields& fresh) {
  return (dragged.fields().values - fresh.values).cwiseAbs().maxCoeff() / fresh.maxValue;
}

std::int64_t ownersThatDiffer(const ValueFields& dragged, const TissueFields& fresh) {
  const auto right = vertexOwners(fresh);
  std::int64_t wrong = 0;
  for (std::size_t v = 0; v < right.size(); ++v) wrong += right[v] != dragged.owners()[v];
  return wrong;
}

mesh::Spline shifted(const mesh::Spline& spline, std::size_t point, const Vector3& by) {
  auto points = spline.points();
  points[point] += by;
  return mesh::Spline(points);
}

}  // namespace

TEST_CASE("fields under the hand are those of a solve from scratch, to two percent") {
  const int resolution = GENERATE(10, 22);
  INFO("resolution " << resolution);
  Scene scene(resolution);
  ValueFields dragged = scene.settled();
  const FieldMatrix before = dragged.fields().values;
  const auto ownersBefore = dragged.owners();
  const CurveRef curve{0, 1};
  dragged.prepareMove({curve});
  CHECK(!dragged.isAdrift());
  CHECK(dragged.fields().values == before);

  FieldMatrix seen = before;
  auto seenOwners = ownersBefore;
  auto moved = scene.list;
  for (int frame = 1; frame <= 10; ++frame) {
    const double s = 0.03 * frame;
    moved[0].curves[1].spline =
        shifted(scene.list[0].curves[1].spline, 1, Vector3(-2.0 * s, s, 0.5 * s));
    const auto changed = dragged.moveCurves({{curve, moved[0].curves[1].spline}});
    CHECK(dragged.isAdrift());
    CHECK(std::ranges::is_sorted(changed.vertices));
    std::int64_t owners = 0;
    for (const std::int32_t v : changed.vertices) {
      for (const std::int32_t j : changed.fields) seen(v, j) = dragged.fields().values(v, j);
      owners += seenOwners[std::size_t(v)] != dragged.owners()[std::size_t(v)];
      seenOwners[std::size_t(v)] = dragged.owners()[std::size_t(v)];
    }
    CHECK(owners == changed.owners);
    // Whoever looks only where he is told to sees the same but for a hair
    CHECK((seen - dragged.fields().values).cwiseAbs().maxCoeff() <
          1.2 * (1.1 * MovedFields::kToldMoved + 10 * ValueFields::kTold));
    CHECK(seenOwners == dragged.owners());
    CHECK(dragged.owners() == vertexOwners(dragged.fields()));
    const TissueFields fresh = scene.anew(moved);
    // The change is seen at all: most of it would be too much
    CHECK((fresh.values - before).cwiseAbs().maxCoeff() > 0.05 * fresh.maxValue);
    CHECK(off(dragged, fresh) < 0.02);
    CHECK(ownersThatDiffer(dragged, fresh) <= 1 + fresh.values.rows() / 200);
    CHECK(changed.error < 0.02);
  }
  // Nothing piles up: at the start everything is as it was but for the same error
  (void)dragged.moveCurves({{curve, scene.list[0].curves[1].spline}});
  CHECK((dragged.fields().values - before).cwiseAbs().maxCoeff() < 0.01 * 1.2);
}

TEST_CASE("a second curve is taken along, and the first stays where it was left") {
  Scene scene;
  ValueFields dragged = scene.settled();
  auto moved = scene.list;
  moved[0].curves[0].spline = shifted(moved[0].curves[0].spline, 1, Vector3(-0.2, 0.1, 0.0));
  (void)dragged.moveCurves({{{0, 0}, moved[0].curves[0].spline}});
  moved[2].curves[0].spline = shifted(moved[2].curves[0].spline, 1, Vector3(0.1, -0.2, 0.1));
  const FieldMatrix before = dragged.fields().values;
  const auto changed = dragged.moveCurves({{{2, 0}, moved[2].curves[0].spline}});
  CHECK(off(dragged, scene.anew(moved)) < 0.02);
  FieldMatrix seen = before;
  for (const std::int32_t v : changed.vertices)
    for (const std::int32_t j : changed.fields) seen(v, j) = dragged.fields().values(v, j);
  CHECK((seen - dragged.fields().values).cwiseAbs().maxCoeff() <
        1.2 * (1.1 * MovedFields::kToldMoved + 10 * ValueFields::kTold));
  // Told of one alone, the other stays as well
  moved[0].curves[0].spline = shifted(moved[0].curves[0].spline, 0, Vector3(0.05, 0.0, 0.0));
  (void)dragged.moveCurves({{{0, 0}, moved[0].curves[0].spline}});
  CHECK(off(dragged, scene.anew(moved)) < 0.02);
  CHECK(dragged.tissues()[2].curves[0].spline.points() == moved[2].curves[0].spline.points());
}

TEST_CASE("fields after edits of values follow curves as well") {
  Scene scene;
  ValueFields dragged = scene.settled();
  scene.list[1].curves[0].values = {2.0, 1.0, 0.5};
  scene.options.fat = 0.15;
  REQUIRE(dragged.setValues(1, {{2.0, 1.0, 0.5}}, scene.run));
  (void)dragged.setFat(0.15);
  auto moved = scene.list;
  for (const std::size_t t : {std::size_t(1), std::size_t(2)}) {
    moved[t].curves[0].spline = shifted(moved[t].curves[0].spline, 1, Vector3(0.1, -0.1, 0.05));
    (void)dragged.moveCurves({{{t, 0}, moved[t].curves[0].spline}});
  }
  CHECK(off(dragged, scene.anew(moved)) < 0.02);
}

TEST_CASE("a curve may go anywhere") {
  Scene scene;
  ValueFields dragged = scene.settled();
  const FieldMatrix before = dragged.fields().values;
  const mesh::Spline& spline = scene.list[1].curves[0].spline;
  const auto goTo = [&](const Vector3& by, const Vector3& end) {
    auto points = spline.points();
    for (Vector3& p : points) p += by;
    points.back() += end;
    const auto changed = dragged.moveCurves({{{1, 0}, mesh::Spline(points)}});
    CHECK(dragged.fields().values.allFinite());
    CHECK(std::isfinite(changed.error));
    return mesh::Spline(points);
  };
  // Half outside, onto another curve, far away, back
  (void)goTo({0.0, 0.3, 0.0}, {0.0, 0.5, 1.0});
  {
    auto moved = scene.list;
    moved[1].curves[0].spline = scene.list[2].curves[0].spline;
    (void)dragged.moveCurves({{{1, 0}, moved[1].curves[0].spline}});
    CHECK(dragged.fields().values.allFinite());
    CHECK(off(dragged, scene.anew(moved)) < 0.03);
  }
  (void)goTo({50.0, 0.0, 0.0}, {0.0, 0.0, 0.0});
  // As if it were not there: its own field is nothing
  CHECK(dragged.fields().values.col(2).cwiseAbs().maxCoeff() < 0.03);
  (void)goTo({0.0, 0.0, 0.0}, {0.0, 0.0, 0.0});
  CHECK((dragged.fields().values - before).cwiseAbs().maxCoeff() < 0.012);
}

TEST_CASE("anisotropic fields follow what moves beside them, by their own equations") {
  Scene scene;
  scene.list[3].anisotropy = {1.0, 0.4, 0.3};
  ValueFields dragged = scene.settledToFollow();
  const FieldMatrix before = dragged.fields().values;
  auto moved = scene.list;
  moved[0].curves[0].spline = shifted(moved[0].curves[0].spline, 1, Vector3(-0.2, -0.3, 0.0));
  (void)dragged.moveCurves({{{0, 0}, moved[0].curves[0].spline}});
  const TissueFields fresh = scene.anew(moved);
  CHECK((before.col(4) - fresh.values.col(4)).cwiseAbs().maxCoeff() > 0.03 * fresh.maxValue);
  CHECK(off(dragged, fresh) < 0.02);
}

TEST_CASE("an anisotropic field follows its own curve, and its medium with it") {
  const Anisotropy medium =
      GENERATE(Anisotropy{1.0, 0.4, 0.3}, Anisotropy{0.2, 3.0, 0.0}, Anisotropy{8.0, 0.3, 1.0});
  INFO("medium " << medium.lambda2 << " " << medium.lambda3 << " " << medium.rotation);
  Scene scene(18);
  scene.list[0].anisotropy = medium;
  scene.list[2].anisotropy = {0.5, 2.0, 0.2};
  ValueFields dragged = scene.settledToFollow();
  const FieldMatrix before = dragged.fields().values;
  auto moved = scene.list;
  for (int frame = 1; frame <= 6; ++frame) {
    const double s = 0.06 * frame;
    moved[0].curves[1].spline =
        shifted(scene.list[0].curves[1].spline, 1, Vector3(-2.0 * s, s, 0.5 * s));
    (void)dragged.moveCurves({{{0, 1}, moved[0].curves[1].spline}});
    const TissueFields fresh = scene.anew(moved);
    INFO("frame " << frame);
    CHECK((before.col(1) - fresh.values.col(1)).cwiseAbs().maxCoeff() > 0.05 * fresh.maxValue);
    CHECK(off(dragged, fresh) < 0.02);
    CHECK(ownersThatDiffer(dragged, fresh) <= 1 + fresh.values.rows() / 200);
  }
  // Nothing piles up
  (void)dragged.moveCurves({{{0, 1}, scene.list[0].curves[1].spline}});
  CHECK((dragged.fields().values - before).cwiseAbs().maxCoeff() < 0.01 * 1.2);
  // Another one, out of the skin and back
  auto points = scene.list[2].curves[0].spline.points();
  for (Vector3& p : points) p += Vector3(5.0, 0.0, 0.0);
  (void)dragged.moveCurves({{{2, 0}, mesh::Spline(points)}});
  CHECK(dragged.fields().values.col(3).cwiseAbs().maxCoeff() < 0.02 * 1.2);
  CHECK(dragged.fields().values.allFinite());
  (void)dragged.moveCurves({{{2, 0}, scene.list[2].curves[0].spline}});
  CHECK((dragged.fields().values - before).cwiseAbs().maxCoeff() < 0.01 * 1.2);
}

TEST_CASE("without their own equations anisotropic fields wait while isotropic ones follow") {
  Scene scene;
  scene.list[3].anisotropy = {1.0, 0.4, 0.3};
  ValueFields dragged = scene.settled();
  const FieldMatrix before = dragged.fields().values;
  auto moved = scene.list;
  moved[2].curves[0].spline = shifted(moved[2].curves[0].spline, 1, Vector3(0.1, -0.3, 0.0));
  (void)dragged.moveCurves({{{2, 0}, moved[2].curves[0].spline}});
  CHECK(dragged.fields().values.col(4) == before.col(4));
  const TissueFields fresh = scene.anew(moved);
  for (const Eigen::Index j : {0, 1, 2, 3})
    CHECK((dragged.fields().values.col(j) - fresh.values.col(j)).cwiseAbs().maxCoeff() <
          0.02 * fresh.maxValue);
}

TEST_CASE("sweeps solve a tube whose surroundings are right") {
  Scene scene;
  const auto cores =
      traceCurves(*scene.walker, *scene.domain, scene.list, scene.options, scene.run).value();
  const auto factor = scene.solver->factorise(cores, scene.options, scene.run).value();
  const DragGround ground(scene.solver, factor, cores);
  const auto n = ground.pattern->rowCount();
  // Any x, and the force that it answers
  std::mt19937 random(3);
  std::uniform_real_distribution<float> any(-1.0F, 1.0F);
  TubeBlock x(n, 2);
  for (Eigen::Index i = 0; i < x.size(); ++i) x.data()[i] = any(random);
  const auto rows = rowsAround(ground, std::vector<std::int32_t>{n / 2}, 3);
  CHECK(rows.size() > 20);
  CHECK(std::ranges::is_sorted(rows));
  TubeBlock force(std::ssize(rows), 2);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto r = static_cast<std::size_t>(rows[i]);
    Eigen::RowVectorXf sum = float(ground.diagonal(rows[i])) * x.row(rows[i]);
    for (auto e = std::size_t(ground.rows->first[r]); e < std::size_t(ground.rows->first[r + 1]);
         ++e)
      sum += float(ground.K[std::size_t(ground.rows->slot[e])]) * x.row(ground.rows->neighbour[e]);
    force.row(Eigen::Index(i)) = sum;
  }
  std::vector<std::int32_t> place(static_cast<std::size_t>(n));
  for (std::size_t r = 0; r < place.size(); ++r) place[r] = std::int32_t(r);
  TubeBlock y = x;
  for (const std::int32_t r : rows) y.row(r).setZero();
  const double first = sweepTube(ground, ground.K, rows, force, place, 1, y);
  const double last = sweepTube(ground, ground.K, rows, force, place, 200, y);
  CHECK(last < 1e-4 * first);
  CHECK((y - x).cwiseAbs().maxCoeff() < 1e-3);
}
