#pragma once

#include <ecorche/domain/domain.h>

#include <span>

namespace ecorche::tissue {

/// A point of a core and the tet that holds it.
struct WellPoint {
  mesh::Vector3 p;
  std::int32_t tet = -1;
};

/// The radius at which the field of a straight line has the value that the row at p reads [m], by
/// solving the tets around p.
///
/// A line of unit flux through p has the field −ln(r)/2π. Vertices within kWellReach mean edges of
/// p take what the discrete equations give when those farther out, and all on the domain's
/// boundary, have that field exactly; the row then reads −ln(r_e)/2π. This sees the shape of the
/// tets and where in them the line runs, which a multiple of the mean edge (kWellC h, the answer
/// where the tets are too poor to tell) does not: docs/algorithms/tissue_fields.md.
///
/// @param tet      holds p
/// @param tangent  of the line, unit
/// @param h        mean edge of the tet [m]
[[nodiscard]] double wellRadius(const domain::Domain& domain, std::int32_t tet,
                                const mesh::Vector3& p, const mesh::Vector3& tangent, double h);
/// The same for several rows that share the flux of one line, each on a line of its own: their mean
/// reading.
[[nodiscard]] double wellRadius(const domain::Domain& domain, std::span<const WellPoint> points,
                                const mesh::Vector3& tangent, double h);

/// How far around a row the tets are solved, in mean edges [unitless].
inline constexpr double kWellReach = 1.5;
/// A well radius is kept between this many times the guess and one over it [unitless].
inline constexpr double kLeastWell = 0.3;

}  // namespace ecorche::tissue
