#include <ecorche/core/parallel.h>
#include <ecorche/fiber/curve_tets.h>
#include <ecorche/fiber/fiber_field.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "fiber/shapes.h"

using namespace ecorche;
using fiber::FiberField;
using fiber::FiberOptions;
using mesh::Vector3;
using test::angleDeg;
using test::makeShape;
using test::Shape;
using test::ShapeRecipe;

namespace {

FiberField fibersOf(const Shape& shape, const std::vector<tissue::CurveTissue>& tissues,
                    const std::vector<fiber::MuscleEnds>& ends, const FiberOptions& options = {}) {
  RunContext run;
  auto field = fiber::computeFibers(shape.anatomy, shape.domain, tissues, ends, options, run);
  INFO((field ? "" : field.error().text()));
  REQUIRE(field);
  return std::move(*field);
}

Vector3 centroid(const Shape& shape, Eigen::Index t) {
  Vector3 sum = Vector3::Zero();
  for (int k = 0; k < 4; ++k)
    sum += 0.25 * shape.anatomy.mesh.V.row(shape.anatomy.mesh.T(t, k)).transpose();
  return sum;
}

// Unit in every muscle's tets and vertices, zero elsewhere.
void checkUnit(const Shape& shape, const FiberField& field) {
  std::vector<bool> touched(static_cast<std::size_t>(shape.anatomy.mesh.V.rows()), false);
  bool tetsGood = true;
  for (Eigen::Index t = 0; t < field.tetFiber.rows(); ++t) {
    const bool muscle = shape.anatomy.label[static_cast<std::size_t>(t)] >= kFirstMuscle;
    tetsGood &= std::abs(field.tetFiber.row(t).norm() - (muscle ? 1.0 : 0.0)) < 1e-12;
    tetsGood &= std::isfinite(field.flow[static_cast<std::size_t>(t)]) == muscle;
    for (int k = 0; muscle && k < 4; ++k)
      touched[static_cast<std::size_t>(shape.anatomy.mesh.T(t, k))] = true;
  }
  CHECK(tetsGood);
  bool verticesGood = true;
  for (Eigen::Index v = 0; v < field.vertexFiber.rows(); ++v) {
    verticesGood &= std::abs(field.vertexFiber.row(v).norm() -
                             (touched[static_cast<std::size_t>(v)] ? 1.0 : 0.0)) < 1e-12;
  }
  CHECK(verticesGood);
}

// Largest angle over all muscle tets between the fibre and what it should be at the centroid.
template <class Truth>
double worstAngle(const Shape& shape, const FiberField& field, const Truth& truth) {
  double worst = 0.0;
  for (Eigen::Index t = 0; t < field.tetFiber.rows(); ++t) {
    if (shape.anatomy.label[static_cast<std::size_t>(t)] < kFirstMuscle) continue;
    worst = std::max(worst, angleDeg(field.tetFiber.row(t).transpose(), truth(centroid(shape, t))));
  }
  return worst;
}

// Mean over volume of the same.
template <class Truth>
double meanAngle(const Shape& shape, const FiberField& field, const Truth& truth) {
  double sum = 0.0;
  double volume = 0.0;
  for (Eigen::Index t = 0; t < field.tetFiber.rows(); ++t) {
    if (shape.anatomy.label[static_cast<std::size_t>(t)] < kFirstMuscle) continue;
    const double v = mesh::signedVolume(shape.anatomy.mesh, t);
    sum += v * angleDeg(field.tetFiber.row(t).transpose(), truth(centroid(shape, t)));
    volume += v;
  }
  return sum / volume;
}

ShapeRecipe cylinder(double radius = 0.02, double length = 0.2) {
  ShapeRecipe recipe;
  recipe.map = [=](const Vector3& g) {
    Vector3 p = radius * test::roundedSection(g);
    p.z() = length * g.z();
    return p;
  };
  return recipe;
}

}  // namespace

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

TEST_CASE("a line in faces and edges of tets is measured once") {
  // The axis of a cylinder runs along edges of its grid, a shifted one through insides
  const Shape shape = makeShape(cylinder());
  std::vector<std::int32_t> upper;
  std::vector<std::int32_t> all;
  for (Eigen::Index t = 0; t < shape.anatomy.mesh.T.rows(); ++t) {
    all.push_back(static_cast<std::int32_t>(t));
    if (centroid(shape, t).z() > 0.1) upper.push_back(static_cast<std::int32_t>(t));
  }
  for (const double x : {0.0, 0.0013}) {
    const std::vector<Vector3> line{
        {x, x / 3, -0.1}, {x, x / 3, 0.03}, {x, x / 3, 0.15}, {x, x / 3, 0.3}};
    CHECK(fiber::lengthInside(shape.anatomy.mesh, all, line) == Approx(0.2).epsilon(1e-12));
    CHECK(fiber::lengthInside(shape.anatomy.mesh, upper, line) == Approx(0.1).epsilon(1e-12));
    double sum = 0.0;
    for (const auto& hit : fiber::tetsOnCurve(shape.anatomy.mesh, all, line)) {
      CHECK(angleDeg(hit.tangent, Vector3::UnitZ()) < 1e-6);
      sum += hit.length;
    }
    CHECK(sum >= 0.2 * (1 - 1e-12));
  }
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
