// Where muscles begin and end, and what has no end.

#include <catch2/catch.hpp>

#include "fiber/fibers.h"

using namespace ecorche;
using fiber::FiberField;
using fiber::FiberOptions;
using mesh::Vector3;
using namespace ecorche::test;

TEST_CASE("what lies past both ends has fibres too") {
  // The muscle grows past its curve's ends: dead ends of the flow, where it dies away exponentially
  ShapeRecipe recipe = cylinder(0.01, 0.4);
  recipe.cells = {6, 6, 60};
  using Kind = domain::BoundaryTag::Kind;
  recipe.tag = [](const Vector3& g) -> domain::BoundaryTag {
    if (g.z() > 0.3 && g.z() < 0.35 && g.x() < 1e-9) return {Kind::Bone, 0};
    if (g.z() > 0.65 && g.z() < 0.7 && g.x() < 1e-9) return {Kind::Bone, 1};
    return {Kind::Skin, 0};
  };
  const Shape shape = makeShape(recipe);
  const auto muscle = test::muscleAlong("m", {{-0.009, 0, 0.13}, {0, 0, 0.2}, {-0.009, 0, 0.27}});
  const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()});
  checkUnit(shape, field);
  CHECK(field.muscles[0].origins[0].onAttachment);
}

TEST_CASE("where nothing flows, fibres are those of the neighbours") {
  // Thirty radii past the attachment the flow has died away to less than a double tells apart
  ShapeRecipe recipe = cylinder(0.01, 0.6);
  recipe.cells = {4, 4, 60};
  using Kind = domain::BoundaryTag::Kind;
  recipe.tag = [](const Vector3& g) -> domain::BoundaryTag {
    if (g.z() > 0.6 && g.z() < 0.65 && g.x() < 1e-9) return {Kind::Bone, 0};
    if (g.z() > 1.0 - 1e-9) return {Kind::Bone, 1};
    return {Kind::Skin, 0};
  };
  const Shape shape = makeShape(recipe);
  const auto muscle = test::muscleAlong("dead end", {{-0.009, 0, 0.37}, {0, 0, 0.45}, {0, 0, 0.6}});
  const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()});
  checkUnit(shape, field);
  CHECK(field.muscles[0].spreadTets > 0);
  CHECK(field.muscles[0].angleToCurveDeg < 15.0);
  CHECK(std::ranges::any_of(field.findings,
                            [](const Finding& f) { return f.kind == "fibers-spread"; }));
}

TEST_CASE("tendon is the first and last share of the flow, and fibres are shorter for it") {
  const Shape shape = makeShape(cylinder());
  const auto muscle = test::muscleAlong("tendon", {{0, 0, 0}, {0, 0, 0.2}});
  FiberOptions options;
  options.tendonShare = 0.2;
  const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()}, options);
  double tendon = 0.0;
  for (Eigen::Index t = 0; t < field.tetFiber.rows(); ++t) {
    if (field.tendon[static_cast<std::size_t>(t)])
      tendon += mesh::signedVolume(shape.anatomy.mesh, t);
  }
  CHECK(tendon / shape.domain.volume == Approx(0.4).epsilon(0.06));
  CHECK(field.muscles[0].fiberLength == Approx(0.12).epsilon(0.03));
}

TEST_CASE("an end in the air uses the muscle's tip and says so only where a bone was asked for") {
  ShapeRecipe recipe = cylinder();
  recipe.tag = [](const Vector3&) -> domain::BoundaryTag {
    return {domain::BoundaryTag::Kind::Skin, 0};
  };
  const Shape shape = makeShape(recipe);
  const auto muscle = test::muscleAlong("free", {{0, 0, 0.01}, {0, 0, 0.19}});
  auto ends = test::boneToBone();
  ends[0].insertion = {fiber::CurveEnd::On::Free, -1, {}};
  const FiberField field = fibersOf(shape, {muscle}, {ends});
  CHECK_FALSE(field.muscles[0].origins[0].onAttachment);
  CHECK_FALSE(field.muscles[0].insertions[0].onAttachment);
  CHECK(std::ranges::count_if(field.findings,
                              [](const Finding& f) { return f.kind == "end-not-reached"; }) == 1);
  CHECK(field.muscles[0].angleToCurveDeg < 5.0);
}

TEST_CASE("sites widen an attachment beyond the curve's end") {
  ShapeRecipe recipe = cylinder();
  using Kind = domain::BoundaryTag::Kind;
  recipe.tag = [](const Vector3& g) -> domain::BoundaryTag {
    if (g.z() > 1.0 - 1e-9) return {Kind::Bone, 1};
    return g.x() < 1e-9 ? domain::BoundaryTag{Kind::Bone, 0} : domain::BoundaryTag{Kind::Skin, 0};
  };
  const Shape shape = makeShape(recipe);
  const auto muscle = test::muscleAlong("m", {{-0.018, 0, 0.01}, {0, 0, 0.1}, {0, 0, 0.2}});
  auto ends = test::boneToBone();
  const double alone = fibersOf(shape, {muscle}, {ends}).muscles[0].origins[0].area;
  ends[0].origin.sites = {Vector3(-0.018, 0, 0.1)};
  CHECK(fibersOf(shape, {muscle}, {ends}).muscles[0].origins[0].area > 1.3 * alone);
}

TEST_CASE("a piece without an end is an error that names muscle and place, a speck is a note") {
  // Fat cuts the muscle in two across its curve
  ShapeRecipe recipe = cylinder();
  recipe.label = [](const Vector3& g) {
    return std::abs(g.z() - 0.5) < 0.05 ? kFat : kFirstMuscle;
  };
  const auto muscle = test::muscleAlong("pinched", {{0, 0, 0}, {0, 0, 0.2}});
  RunContext run;
  {
    const Shape shape = makeShape(recipe);
    const auto field =
        fiber::computeFibers(shape.anatomy, shape.domain, {muscle}, {test::boneToBone()}, {}, run);
    REQUIRE_FALSE(field);
    CHECK(field.error().code == ErrorCode::FiberWithoutEnds);
    CHECK(field.error().place.object == "pinched");
    CHECK(field.error().place.point);
    CHECK(field.error().message.find("pinched") != std::string::npos);

    // Asked to go on, both pieces follow the curve and are named
    FiberOptions options;
    options.unendedPiece = fiber::UnendedPiece::FollowCurve;
    const FiberField along = fibersOf(shape, {muscle}, {test::boneToBone()}, options);
    checkUnit(shape, along);
    CHECK(worstAngle(shape, along, [](const Vector3&) { return Vector3::UnitZ(); }) < 1e-6);
    CHECK(std::ranges::count_if(along.findings, [](const Finding& f) {
            return f.kind == "piece-without-ends" && f.severity == Severity::Warning &&
                   f.object == "pinched" && f.point && f.size > 0.0;
          }) == 2);
  }
  recipe.label = [](const Vector3& g) {
    const double off = (g - Vector3(0.95, 0.95, 0.5)).cwiseAbs().maxCoeff();
    return off < 0.06 ? kFirstMuscle : g.x() > 0.7 ? kFat : kFirstMuscle;
  };
  const Shape shape = makeShape(recipe);
  const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()});
  checkUnit(shape, field);
  CHECK(std::ranges::any_of(field.findings,
                            [](const Finding& f) { return f.kind == "speck-without-ends"; }));
}

TEST_CASE("fillers and fat have no fibres, and cancelling stops") {
  ShapeRecipe recipe = cylinder();
  recipe.label = [](const Vector3& g) { return TissueId{g.x() < 0.4 ? 2 : g.x() < 0.6 ? 3 : 1}; };
  const Shape shape = makeShape(recipe);
  const auto muscle = test::muscleAlong("m", {{-0.01, 0, 0}, {-0.01, 0, 0.2}});
  auto filler = test::muscleAlong("belly", {{0, 0, 0}, {0, 0, 0.2}});
  filler.filler = true;
  const FiberField field = fibersOf(shape, {muscle, filler}, {test::boneToBone(), {}});
  CHECK(field.muscles.size() == 1);
  for (Eigen::Index t = 0; t < field.tetFiber.rows(); ++t) {
    REQUIRE(field.tetFiber.row(t).norm() ==
            Approx(shape.anatomy.label[static_cast<std::size_t>(t)].value == 2 ? 1.0 : 0.0));
  }
  RunContext run;
  run.cancel();
  const auto stopped = fiber::computeFibers(shape.anatomy, shape.domain, {muscle, filler},
                                            {test::boneToBone(), {}}, {}, run);
  REQUIRE_FALSE(stopped);
  CHECK(stopped.error().code == ErrorCode::Cancelled);
}
