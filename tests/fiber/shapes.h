#pragma once

#include <ecorche/domain/domain.h>
#include <ecorche/envelope/anatomy.h>
#include <ecorche/fiber/fiber_field.h>

#include <array>
#include <functional>
#include <vector>

namespace ecorche::test {

/// A body made of mapped grid cells, six tets each, that is its own anatomy: every tet is its own
/// parent.
struct Shape {
  domain::Domain domain;
  envelope::Anatomy anatomy;
};

/// What a grid is mapped to and how it is labelled; grid coordinates are in [0, 1]³.
struct ShapeRecipe {
  std::array<int, 3> cells{8, 8, 24};
  std::function<mesh::Vector3(const mesh::Vector3&)> map = [](const mesh::Vector3& g) { return g; };
  /// Tissue of a tet by the grid coordinates of its centroid.
  std::function<TissueId(const mesh::Vector3&)> label = [](const mesh::Vector3&) {
    return kFirstMuscle;
  };
  /// Tag of a boundary face by the grid coordinates of its centroid. Default: bone 0 below, bone 1
  /// above, skin around.
  std::function<domain::BoundaryTag(const mesh::Vector3&)> tag;
};

[[nodiscard]] Shape makeShape(const ShapeRecipe& recipe);

/// As makeShape, with the anatomy cut where a function changes its sign instead of labelled tet by
/// tet: positive is muscle (kFirstMuscle), the rest fat. Crossings keep `clamp` away from the ends
/// of their edge, as the envelope's do, so tets are as skinny as those that the envelope leaves.
/// Inner vertices are moved at random by a share of a cell.
[[nodiscard]] Shape makeCutShape(const ShapeRecipe& recipe,
                                 const std::function<double(const mesh::Vector3&)>& inside,
                                 double clamp = 1e-3, double jitter = 0.2);

/// Square [0, 1]² to a nearly round disc of radius 1 about the origin.
[[nodiscard]] mesh::Vector3 roundedSection(const mesh::Vector3& grid);

/// A muscle with one straight or bent curve from bone 0 to bone 1.
[[nodiscard]] tissue::CurveTissue muscleAlong(std::string name, std::vector<mesh::Vector3> points);
[[nodiscard]] fiber::MuscleEnds boneToBone(std::size_t curves = 1);

/// Angle between two unit vectors [degrees].
[[nodiscard]] double angleDeg(const mesh::Vector3& a, const mesh::Vector3& b);

}  // namespace ecorche::test
