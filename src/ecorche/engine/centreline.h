#pragma once

#include <ecorche/mesh/surface_mesh.h>

#include <optional>
#include <vector>

namespace ecorche::engine {

/// The middle of a muscle's surface from one attachment to the other.
struct Centreline {
  std::vector<mesh::Vector3> points;  ///< at even steps [m]
  double inside = 0.0;                ///< share of them within the muscle
  double radius = 0.0;                ///< of a disc as large as the middle cross-section [m]
};

/// Centres of the cross-sections of a muscle whose shape is known. These are where a harmonic
/// function on its surface, 0 at one attachment and 1 at the other, takes a value: through each
/// the same amount flows, so that a branch that ends blind has none. Where a value is taken in
/// several loops, the one through which most flows counts.
///
/// @param muscle  closed or nearly so; edges may have any number of faces
/// @param from, to  patches where it is attached [m]; vertices of the muscle that are as near to
///                  one as 0.2 % of the muscle's diagonal beyond its nearest are on it
/// @return  nothing where no part of the surface joins the two
[[nodiscard]] std::optional<Centreline> centrelineOf(const mesh::SurfaceMesh& muscle,
                                                     const mesh::SurfaceMesh& from,
                                                     const mesh::SurfaceMesh& to);

}  // namespace ecorche::engine
