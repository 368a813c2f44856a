#include <ecorche/core/parallel.h>
#include <ecorche/fiber/curve_tets.h>

#include <catch2/catch.hpp>
#include <numbers>
#include <numeric>
#include <random>

#include "fiber/fibers.h"

using namespace ecorche;
using fiber::FiberField;
using fiber::FiberOptions;
using mesh::Vector3;
using namespace ecorche::test;

TEST_CASE("fibres of a straight cylinder run along its axis and are as long as it is") {
  const Shape shape = makeShape(cylinder());
  const auto muscle = test::muscleAlong("cylinder", {{0, 0, 0}, {0, 0, 0.2}});
  const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()});
  checkUnit(shape, field);
  CHECK(worstAngle(shape, field, [](const Vector3&) { return Vector3::UnitZ(); }) < 1e-6);

  REQUIRE(field.muscles.size() == 1);
  const auto& figures = field.muscles[0];
  CHECK(figures.lines.size() == 100);
  CHECK(figures.fiberLength == Approx(0.2).epsilon(0.01));
  CHECK(figures.fiberLengthSd < 0.002);
  CHECK(figures.angleToCurveDeg < 1e-6);
  CHECK(figures.curveTets > 0);
  CHECK(figures.interiorExtrema == 0);
  CHECK(figures.origins[0].onAttachment);
  CHECK(figures.insertions[0].centroid.z() == Approx(0.2));
}

TEST_CASE(
    "a curve that is not the axis turns fibres, more the heavier it weighs, and no weight leaves "
    "the flow alone") {
  const Shape shape = makeShape(cylinder());
  const auto muscle = test::muscleAlong("slanted", {{-0.01, 0, 0}, {0, 0, 0.1}, {0.01, 0, 0.2}});
  FiberOptions options;
  options.curveWeight = 0.0;
  CHECK(worstAngle(shape, fibersOf(shape, {muscle}, {test::boneToBone()}, options),
                   [](const Vector3&) { return Vector3::UnitZ(); }) < 1e-6);
  double before = 180.0;
  for (const double weight : {0.0, 1.0, 10.0, 100.0}) {
    options.curveWeight = weight;
    const double angle =
        fibersOf(shape, {muscle}, {test::boneToBone()}, options).muscles[0].angleToCurveDeg;
    CHECK(angle < before);
    before = angle;
  }
}

TEST_CASE("fibres of a cylinder that is cut off at a slant still run along its axis") {
  for (const double slope : {0.5, 1.0, 1.7}) {
    ShapeRecipe recipe = cylinder(0.015, 0.15);
    recipe.cells = {8, 8, 24};
    const auto straight = recipe.map;
    recipe.map = [&](const Vector3& g) {
      Vector3 p = straight(g);
      p.z() += slope * p.x();
      return p;
    };
    const Shape shape = makeShape(recipe);
    const auto muscle = test::muscleAlong("slanted", {{0, 0, 0}, {0, 0, 0.15}});
    const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()});
    checkUnit(shape, field);
    const auto axis = [](const Vector3&) { return Vector3::UnitZ(); };
    // As much flows through every part of a slanted end as along the axis: the flow is even, as
    // long as the whole end counts as attachment (it reaches one radius along the curve)
    CHECK(worstAngle(shape, field, axis) < (slope <= 1.0 ? 1e-6 : 20.0));
    CHECK(meanAngle(shape, field, axis) < 1.0);
    CHECK(field.muscles[0].interiorExtrema == 0);
    CHECK(field.muscles[0].fiberLength == Approx(0.15).epsilon(0.03));
    CHECK(field.muscles[0].lines.size() >= 95);
  }
}

TEST_CASE("fibres of a bend are azimuthal") {
  ShapeRecipe recipe;
  recipe.cells = {8, 8, 32};
  recipe.map = [](const Vector3& g) {
    const Vector3 p = 0.02 * test::roundedSection(g);
    const double a = 0.5 * std::numbers::pi * g.z();
    return Vector3((0.1 + p.x()) * std::cos(a), p.y(), (0.1 + p.x()) * std::sin(a));
  };
  const Shape shape = makeShape(recipe);
  std::vector<Vector3> points;
  for (int k = 0; k <= 8; ++k) {
    const double a = 0.5 * std::numbers::pi * k / 8;
    points.emplace_back(0.1 * std::cos(a), 0.0, 0.1 * std::sin(a));
  }
  const FiberField field =
      fibersOf(shape, {test::muscleAlong("bend", points)}, {test::boneToBone()});
  checkUnit(shape, field);
  const auto azimuthal = [](const Vector3& x) { return Vector3(-x.z(), 0.0, x.x()).normalized(); };
  CHECK(meanAngle(shape, field, azimuthal) < 1.5);
  CHECK(worstAngle(shape, field, azimuthal) < 6.0);
  CHECK(field.muscles[0].angleToCurveDeg < 3.0);
  CHECK(field.muscles[0].interiorExtrema == 0);
  // Inner fibres are shorter, outer longer; the mean is that of the axis
  CHECK(field.muscles[0].fiberLength == Approx(0.1 * 0.5 * std::numbers::pi).epsilon(0.02));
  CHECK(field.muscles[0].fiberLengthSd > 0.005);
}

TEST_CASE("fibres of a triangular muscle fan out from its apex") {
  // A sector between two spheres about the apex: the flow without a curve is exactly radial
  ShapeRecipe recipe;
  recipe.cells = {16, 6, 24};
  recipe.map = [](const Vector3& g) {
    const double a = 0.6 * (2.0 * g.x() - 1.0);
    const double b = 0.15 * (2.0 * g.y() - 1.0);
    const double rho = 0.05 + 0.15 * g.z();
    return Vector3(rho * Vector3(std::tan(a), std::tan(b), 1.0).normalized());
  };
  const Shape shape = makeShape(recipe);
  const auto muscle = test::muscleAlong("deltoid", {{0, 0, 0.05}, {0, 0, 0.2}});
  const auto radial = [](const Vector3& x) { return Vector3(x.normalized()); };
  FiberOptions options;
  options.curveWeight = 0.0;
  CHECK(meanAngle(shape, fibersOf(shape, {muscle}, {test::boneToBone()}, options), radial) < 1.0);
  const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()});
  checkUnit(shape, field);
  CHECK(meanAngle(shape, field, radial) < 8.0);
  CHECK(field.muscles[0].angleToCurveDeg < 5.0);
  CHECK(field.muscles[0].fiberLength == Approx(0.15).epsilon(0.03));
}

TEST_CASE("fibres of a fusiform muscle bulge with it") {
  ShapeRecipe recipe;
  const auto radius = [](double z) { return 0.012 + 0.02 * std::sin(std::numbers::pi * z); };
  recipe.map = [&](const Vector3& g) {
    Vector3 p = radius(g.z()) * test::roundedSection(g);
    p.z() = 0.2 * g.z();
    return p;
  };
  const Shape shape = makeShape(recipe);
  const auto muscle = test::muscleAlong("biceps", {{0, 0, 0}, {0, 0, 0.1}, {0, 0, 0.2}});
  const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()});
  checkUnit(shape, field);
  // Similar sections: a fibre keeps its share of the radius
  const auto bulging = [&](const Vector3& x) {
    const double z = x.z() / 0.2;
    const double slope = 0.02 * std::numbers::pi * std::cos(std::numbers::pi * z) / 0.2;
    return Vector3(x.x() / radius(z) * slope, x.y() / radius(z) * slope, 1.0).normalized();
  };
  CHECK(meanAngle(shape, field, bulging) < 6.0);
  CHECK(field.muscles[0].interiorExtrema == 0);
  CHECK(field.muscles[0].fiberLength > 0.2 * 0.99);
  CHECK(field.muscles[0].fiberLength < 0.215);
}

TEST_CASE("fibres of a unipennate muscle run obliquely between two long attachments") {
  // Origin along the lower side, insertion along the upper, shifted: fibres cross at an angle
  using Kind = domain::BoundaryTag::Kind;
  ShapeRecipe recipe;
  recipe.cells = {8, 8, 32};
  recipe.map = [](const Vector3& g) {
    return Vector3(0.03 * (g.x() - 0.5), 0.03 * (g.y() - 0.5), 0.2 * (g.z() - 0.5));
  };
  recipe.tag = [](const Vector3& g) -> domain::BoundaryTag {
    if (g.x() < 1e-9 && g.z() < 0.5) return {Kind::Bone, 0};
    if (g.x() > 1.0 - 1e-9 && g.z() > 0.5) return {Kind::Bone, 1};
    return {Kind::Skin, 0};
  };
  const Shape shape = makeShape(recipe);
  const auto muscle = test::muscleAlong("unipennate", {{-0.015, 0, -0.05}, {0.015, 0, 0.05}});
  FiberOptions options;
  options.attachmentReachRel = 10.0;
  const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()}, options);
  checkUnit(shape, field);
  Vector3 mean = Vector3::Zero();
  for (Eigen::Index t = 0; t < field.tetFiber.rows(); ++t) {
    const Vector3 x = centroid(shape, t);
    if (std::abs(x.z()) < 0.02)
      mean += mesh::signedVolume(shape.anatomy.mesh, t) * field.tetFiber.row(t).transpose();
  }
  mean.normalize();
  const double pennation = angleDeg(mean, Vector3::UnitZ());
  CHECK(pennation > 10.0);
  CHECK(pennation < 60.0);
  CHECK(mean.x() > 0.0);
  CHECK(std::abs(mean.y()) < 0.02);
  CHECK(field.muscles[0].fiberLength < 0.2);
  CHECK(field.muscles[0].angleToCurveDeg < 15.0);
}

TEST_CASE("two heads share a belly and each runs from its own origin") {
  // A slot along the axis parts the heads over the first half
  using Kind = domain::BoundaryTag::Kind;
  ShapeRecipe recipe;
  recipe.cells = {12, 6, 24};
  recipe.map = [](const Vector3& g) {
    const double spread = 0.5 + 0.5 * std::max(0.0, 1.0 - 2.0 * g.z());
    return Vector3(0.06 * spread * (g.x() - 0.5), 0.02 * (g.y() - 0.5), 0.2 * g.z());
  };
  recipe.label = [](const Vector3& g) {
    return std::abs(g.x() - 0.5) < 1.01 / 12 && g.z() < 0.5 ? kFat : kFirstMuscle;
  };
  recipe.tag = [](const Vector3& g) -> domain::BoundaryTag {
    if (g.z() < 1e-9) return {Kind::Bone, g.x() < 0.5 ? 0 : 2};
    if (g.z() > 1.0 - 1e-9) return {Kind::Bone, 1};
    return {Kind::Skin, 0};
  };
  const Shape shape = makeShape(recipe);
  tissue::CurveTissue muscle =
      test::muscleAlong("biceps", {{-0.02, 0, 0}, {-0.007, 0, 0.1}, {0, 0, 0.2}});
  muscle.curves.push_back(
      test::muscleAlong("short head", {{0.02, 0, 0}, {0.007, 0, 0.1}, {0, 0, 0.2}}).curves[0]);
  auto ends = test::boneToBone(2);
  ends[1].origin.index = 2;
  const FiberField field = fibersOf(shape, {muscle}, {ends});
  const auto& figures = field.muscles[0];
  REQUIRE(figures.origins.size() == 2);
  CHECK(figures.origins[0].onAttachment);
  CHECK(figures.origins[1].onAttachment);
  CHECK(figures.origins[0].centroid.x() < -0.01);
  CHECK(figures.origins[1].centroid.x() > 0.01);
  CHECK(figures.angleToCurveDeg < 15.0);
  for (Eigen::Index t = 0; t < field.tetFiber.rows(); ++t) {
    if (shape.anatomy.label[static_cast<std::size_t>(t)] < kFirstMuscle) {
      CHECK(field.tetFiber.row(t).isZero());
    } else if (centroid(shape, t).z() > 0.02) {
      REQUIRE(field.tetFiber(t, 2) > 0.0);
    }
  }
}

namespace {

// A slab 40 mm wide, 30 mm thick and 200 mm long that lies on bone 0 with its whole underside;
// bone 2 closes it before, bone 1 behind.
Shape slabOnBone() {
  using Kind = domain::BoundaryTag::Kind;
  ShapeRecipe recipe;
  recipe.cells = {8, 8, 40};
  recipe.map = [](const Vector3& g) {
    return Vector3(0.04 * (g.x() - 0.5), 0.03 * g.y(), 0.2 * g.z());
  };
  recipe.tag = [](const Vector3& g) -> domain::BoundaryTag {
    if (g.z() < 1e-9) return {Kind::Bone, 2};
    if (g.z() > 1.0 - 1e-9) return {Kind::Bone, 1};
    if (g.y() < 1e-9) return {Kind::Bone, 0};
    return {Kind::Skin, 0};
  };
  return makeShape(recipe);
}

// Share of the tets on a muscle's curves whose fibre runs backwards.
double backwardShare(const Shape& shape, const FiberField& field,
                     const tissue::CurveTissue& muscle) {
  std::vector<std::int32_t> all(shape.anatomy.label.size());
  std::iota(all.begin(), all.end(), 0);
  double count = 0.0;
  double backward = 0.0;
  for (const auto& curve : muscle.curves) {
    const auto line = curve.spline.sample(curve.spline.length() / 200).point;
    for (const auto& hit : fiber::tetsOnCurve(shape.anatomy.mesh, all, line)) {
      backward += field.tetFiber.row(hit.tet).dot(hit.tangent.transpose()) < 0.0;
      ++count;
    }
  }
  return backward / count;
}

}  // namespace

TEST_CASE("a head that joins halfway does not turn the others around") {
  // As the medial head of the triceps: its origin lies on the bone under the long heads' path
  const Shape shape = slabOnBone();
  tissue::CurveTissue muscle =
      test::muscleAlong("triceps", {{-0.008, 0.02, 0}, {-0.008, 0.02, 0.1}, {-0.005, 0.016, 0.2}});
  muscle.curves.push_back(
      test::muscleAlong("lateral", {{0.008, 0, 0.03}, {0.008, 0.014, 0.08}, {0.005, 0.016, 0.2}})
          .curves[0]);
  muscle.curves.push_back(
      test::muscleAlong("medial", {{0, 0, 0.11}, {0, 0.008, 0.14}, {0, 0.012, 0.2}}).curves[0]);
  auto ends = test::boneToBone(3);
  ends[0].origin.index = 2;
  const FiberField field = fibersOf(shape, {muscle}, {ends});
  checkUnit(shape, field);
  CHECK(field.muscles[0].angleToCurveDeg < 10.0);
  CHECK(backwardShare(shape, field, muscle) == 0.0);
  CHECK(field.muscles[0].interiorExtrema == 0);

  // How far along is said of each head on its own
  std::vector<std::int32_t> all(shape.anatomy.label.size());
  std::iota(all.begin(), all.end(), 0);
  for (const auto& curve : muscle.curves) {
    const auto line = curve.spline.sample(curve.spline.length() / 200).point;
    const auto flowAbout = [&](double share) {
      const Vector3 at = line[static_cast<std::size_t>(share * static_cast<double>(line.size()))];
      std::int32_t nearest = 0;
      for (const std::int32_t t : all) {
        if ((centroid(shape, t) - at).norm() < (centroid(shape, nearest) - at).norm()) nearest = t;
      }
      return field.flow[static_cast<std::size_t>(nearest)];
    };
    CHECK(flowAbout(0.02) == Approx(0.0).margin(0.15));
    CHECK(flowAbout(0.5) == Approx(0.5).margin(0.2));
    CHECK(flowAbout(0.98) == Approx(1.0).margin(0.15));
  }
}

TEST_CASE("a muscle that lies on its bone of origin all along leaves it at its curve's beginning") {
  const Shape shape = slabOnBone();
  for (const double begin : {0.01, 0.05, 0.1}) {
    const auto muscle =
        test::muscleAlong("profundus", {{0, 0, begin}, {0, 0.012, begin + 0.03}, {0, 0.015, 0.2}});
    const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone()});
    checkUnit(shape, field);
    CHECK(field.muscles[0].angleToCurveDeg < 10.0);
    CHECK(backwardShare(shape, field, muscle) < 0.05);
    CHECK(field.muscles[0].interiorExtrema == 0);
  }
}

TEST_CASE("fascicles side by side between two long bones keep their pennation") {
  // Bone below the first two thirds, bone above the last two: seven curves cross from one to the
  // other
  using Kind = domain::BoundaryTag::Kind;
  ShapeRecipe recipe;
  recipe.cells = {8, 8, 48};
  recipe.map = [](const Vector3& g) {
    return Vector3(0.03 * (g.x() - 0.5), 0.03 * (g.y() - 0.5), 0.2 * g.z());
  };
  recipe.tag = [](const Vector3& g) -> domain::BoundaryTag {
    if (g.x() < 1e-9 && g.z() < 0.7) return {Kind::Bone, 0};
    if (g.x() > 1.0 - 1e-9 && g.z() > 0.3) return {Kind::Bone, 1};
    return {Kind::Skin, 0};
  };
  const Shape shape = makeShape(recipe);
  tissue::CurveTissue muscle =
      test::muscleAlong("unipennate", {{-0.015, 0, 0.01}, {0.015, 0, 0.07}});
  for (int k = 1; k < 7; ++k) {
    const double z = 0.01 + 0.02 * k;
    muscle.curves.push_back(
        test::muscleAlong("fascicle", {{-0.015, 0, z}, {0.015, 0, z + 0.06}}).curves[0]);
  }
  const FiberField field = fibersOf(shape, {muscle}, {test::boneToBone(7)});
  checkUnit(shape, field);
  CHECK(field.muscles[0].angleToCurveDeg < 8.0);
  CHECK(backwardShare(shape, field, muscle) == 0.0);
  CHECK(field.muscles[0].interiorExtrema == 0);
}

TEST_CASE("fibres turn with the model and do not mind its size") {
  const ShapeRecipe straight = cylinder();
  const std::vector<Vector3> points{{-0.005, 0, 0}, {0.005, 0.002, 0.1}, {0, 0, 0.2}};
  const FiberField before =
      fibersOf(makeShape(straight), {test::muscleAlong("m", points)}, {test::boneToBone()});

  for (const double scale : {1024.0, 1000.0}) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    ShapeRecipe moved = straight;
    moved.map = [&](const Vector3& g) { return Vector3(scale * (turn * straight.map(g))); };
    std::vector<Vector3> movedPoints;
    for (const Vector3& p : points) movedPoints.emplace_back(scale * (turn * p));
    const FiberField after =
        fibersOf(makeShape(moved), {test::muscleAlong("m", movedPoints)}, {test::boneToBone()});
    CHECK((after.tetFiber - before.tetFiber * turn.transpose()).cwiseAbs().maxCoeff() < 1e-8);
    CHECK(after.muscles[0].fiberLength ==
          Approx(scale * before.muscles[0].fiberLength).epsilon(1e-6));
    CHECK(after.muscles[0].interiorExtrema == before.muscles[0].interiorExtrema);
  }
}

TEST_CASE("fibres of a bent muscle converge when tets become finer") {
  const auto atCells = [](int n) {
    ShapeRecipe recipe;
    recipe.cells = {2 * n, 2 * n, 6 * n};
    recipe.map = [](const Vector3& g) {
      Vector3 p = (0.015 + 0.01 * g.z()) * test::roundedSection(g);
      p.z() = 0.2 * g.z();
      p.x() += 0.05 * g.z() * g.z();
      return p;
    };
    const Shape shape = makeShape(recipe);
    const auto muscle = test::muscleAlong("m", {{0, 0, 0}, {0.0125, 0, 0.1}, {0.05, 0, 0.2}});
    return fibersOf(shape, {muscle}, {test::boneToBone()}).muscles[0];
  };
  const auto coarse = atCells(3);
  const auto fine = atCells(6);
  CHECK(coarse.fiberLength == Approx(fine.fiberLength).epsilon(0.02));
  CHECK(fine.angleToCurveDeg < 8.0);
  CHECK(std::abs(coarse.angleToCurveDeg - fine.angleToCurveDeg) < 4.0);
}

TEST_CASE("one thread and two give the same bytes") {
  ShapeRecipe recipe = cylinder();
  recipe.label = [](const Vector3& g) { return TissueId{g.x() < 0.5 ? 2 : 3}; };
  const Shape shape = makeShape(recipe);
  const std::vector<tissue::CurveTissue> muscles{
      test::muscleAlong("a", {{-0.01, 0, 0}, {-0.01, 0.002, 0.2}}),
      test::muscleAlong("b", {{0.01, 0, 0}, {0.01, 0.002, 0.2}})};
  const std::vector<fiber::MuscleEnds> ends{test::boneToBone(), test::boneToBone()};
  std::vector<FiberField> fields;
  for (const int threads : {1, 2}) {
    const ThreadLimit limit(threads);
    fields.push_back(fibersOf(shape, muscles, ends));
  }
  CHECK(fields[0].tetFiber == fields[1].tetFiber);
  CHECK(fields[0].vertexFiber == fields[1].vertexFiber);
  CHECK(fields[0].muscles[1].fiberLength == fields[1].muscles[1].fiberLength);
}

namespace {

// A muscle of radius 12 mm about a path in a block of fat, cut out of jittered tets with crossings
// clamped at 1e-3.
Shape cutMuscle(int cells, const std::function<Vector3(double z)>& path) {
  ShapeRecipe recipe;
  recipe.cells = {cells, cells, 3 * cells};
  recipe.map = [](const Vector3& g) {
    return Vector3(0.04 * (g.x() - 0.5), 0.04 * (g.y() - 0.5), 0.12 * g.z());
  };
  return test::makeCutShape(recipe,
                            [&](const Vector3& x) { return 0.012 - (x - path(x.z())).norm(); });
}

tissue::CurveTissue alongPath(const std::function<Vector3(double z)>& path) {
  std::vector<Vector3> points;
  for (int k = 0; k <= 6; ++k) points.push_back(path(0.02 * k));
  return test::muscleAlong("cut", points);
}

}  // namespace

TEST_CASE("slivers of the subdivision do not spoil fibres") {
  const auto straight = [](double z) { return Vector3(0.001, -0.0007, z); };
  for (const int cells : {8, 16}) {
    const Shape shape = cutMuscle(cells, straight);
    const FiberField field = fibersOf(shape, {alongPath(straight)}, {test::boneToBone()});
    checkUnit(shape, field);
    const auto axis = [](const Vector3&) { return Vector3::UnitZ(); };
    CHECK(meanAngle(shape, field, axis) < 0.1);
    CHECK(worstAngle(shape, field, axis) < 10.0);
    CHECK(field.muscles[0].interiorExtrema == 0);
    CHECK(field.muscles[0].fiberLength == Approx(0.12).epsilon(1e-3));
  }
}

TEST_CASE("slivers of a wavy muscle leave no fibre astray") {
  const auto wavy = [](double z) {
    return Vector3(0.008 * std::sin(std::numbers::pi * z / 0.12) - 0.003, -0.0007, z);
  };
  const auto tangent = [](const Vector3& x) {
    return Vector3(0.008 * std::numbers::pi / 0.12 * std::cos(std::numbers::pi * x.z() / 0.12), 0,
                   1)
        .normalized();
  };
  const Shape shape = cutMuscle(8, wavy);
  const FiberField field = fibersOf(shape, {alongPath(wavy)}, {test::boneToBone()});
  CHECK(worstAngle(shape, field, tangent) < 12.0);
  CHECK(meanAngle(shape, field, tangent) < 3.0);
}
