#pragma once

#include <ecorche/fiber/fiber_field.h>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>

#include "fiber/shapes.h"

namespace ecorche::test {

inline fiber::FiberField fibersOf(const Shape& shape,
                                  const std::vector<tissue::CurveTissue>& tissues,
                                  const std::vector<fiber::MuscleEnds>& ends,
                                  const fiber::FiberOptions& options = {}) {
  RunContext run;
  auto field = fiber::computeFibers(shape.anatomy, shape.domain, tissues, ends, options, run);
  INFO((field ? "" : field.error().text()));
  REQUIRE(field);
  return std::move(*field);
}

inline mesh::Vector3 centroid(const Shape& shape, Eigen::Index t) {
  mesh::Vector3 sum = mesh::Vector3::Zero();
  for (int k = 0; k < 4; ++k)
    sum += 0.25 * shape.anatomy.mesh.V.row(shape.anatomy.mesh.T(t, k)).transpose();
  return sum;
}

/// Unit in every muscle's tets and vertices, zero elsewhere.
inline void checkUnit(const Shape& shape, const fiber::FiberField& field) {
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

/// Largest angle over all muscle tets between the fibre and what it should be at the centroid.
template <class Truth>
double worstAngle(const Shape& shape, const fiber::FiberField& field, const Truth& truth) {
  double worst = 0.0;
  for (Eigen::Index t = 0; t < field.tetFiber.rows(); ++t) {
    if (shape.anatomy.label[static_cast<std::size_t>(t)] < kFirstMuscle) continue;
    worst = std::max(worst, angleDeg(field.tetFiber.row(t).transpose(), truth(centroid(shape, t))));
  }
  return worst;
}

/// Mean over volume of the same.
template <class Truth>
double meanAngle(const Shape& shape, const fiber::FiberField& field, const Truth& truth) {
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

inline ShapeRecipe cylinder(double radius = 0.02, double length = 0.2) {
  ShapeRecipe recipe;
  recipe.map = [=](const mesh::Vector3& g) {
    mesh::Vector3 p = radius * roundedSection(g);
    p.z() = length * g.z();
    return p;
  };
  return recipe;
}

}  // namespace ecorche::test
