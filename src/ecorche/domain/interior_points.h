#pragma once

#include <ecorche/domain/sizing_field.h>
#include <ecorche/domain/tagged_surface.h>

#include <cstdint>

namespace ecorche::domain {

/// How many tets a sizing field leads to if all its lengths are multiplied by a scale: so many per
/// volume between the walls, and so many per area of wall. A first guess, before walls are
/// resampled.
class TetEstimate {
 public:
  TetEstimate(const TaggedSurface& walls, const SizingField& sizing);
  [[nodiscard]] double tets(double scale) const;
  /// The scale that leads to this many tets.
  [[nodiscard]] double scaleFor(double tets) const;

 private:
  double perVolume_ = 0.0;  // tets in the volume at scale 1
  double perArea_ = 0.0;    // tets along the walls at scale 1
};

/// Volume of a tet of interiorPoints' lattice [m³].
/// @param edge  its mean edge [m]
[[nodiscard]] double latticeTetVolume(double edge);

/// Tets that a mesher makes of walls and of points between them; within 6 % on limbs of 60 k to 640
/// k.
[[nodiscard]] double tetsOf(std::int64_t points, std::int64_t wallFaces);

/// Vertices for tets: a body-centred lattice that grows from place to place, each point proposing
/// neighbours at its own distance; where lengths change the lattice tears and closes again.
///
/// Of all lattices the body-centred one has the best tets, and the only Delaunay tets without
/// slivers [Labelle & Shewchuk 2007].
///
/// @param walls  closed surface; no point is nearer to it than half a cell
/// @return  points between the walls in the order of growth
[[nodiscard]] mesh::Positions interiorPoints(const TaggedSurface& walls, const SizingField& sizing,
                                             double scale);

}  // namespace ecorche::domain
