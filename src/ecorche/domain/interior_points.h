#pragma once

#include <ecorche/domain/sizing_field.h>
#include <ecorche/mesh/surface_query.h>

namespace ecorche::domain {

/// How many tets interiorPoints would lead to if all lengths were multiplied by `scale`: 12 tets to
/// a body-centred cell [Labelle & Shewchuk 2007], counted by quasi-random points inside the walls.
class TetEstimate {
 public:
  TetEstimate(const mesh::SurfaceQuery& walls, const SizingField& sizing);
  [[nodiscard]] double tets(double scale) const;
  /// The scale that leads to this many tets.
  [[nodiscard]] double scaleFor(double tets) const;

 private:
  double perCubedScale_ = 0.0;
};

/// Vertices for tets: corners and centres of a graded octree whose cells are no larger than the
/// wanted length. They lie inside the walls and no nearer to them than about half that length.
[[nodiscard]] mesh::Positions interiorPoints(const mesh::SurfaceQuery& walls,
                                             const SizingField& sizing, double scale);

}  // namespace ecorche::domain
