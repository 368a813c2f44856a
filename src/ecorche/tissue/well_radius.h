#pragma once

#include <ecorche/domain/domain.h>

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace ecorche::tissue {

/// A point of a core and the tet that holds it.
struct WellPoint {
  mesh::Vector3 p;
  std::int32_t tet = -1;
};

/// By how much the discrete field of a line of unit flux exceeds the line's own at a vertex.
struct LineError {
  std::int32_t vertex = -1;
  double error = 0.0;  // [unitless, as fields over flux]
};

/// What the tets around a row make of a straight line of unit flux.
struct Well {
  double radius = 0.0;  ///< r_e: where the line's field has the value that the row reads [m]
  std::vector<LineError> errors;  ///< at the vertices around; empty where the tets cannot tell
};

/// Solves the tets around rows for straight lines of unit flux.
///
/// A line's field is −ln(r)/2π. Vertices within kWellReach mean edges of the row take what the
/// discrete equations give when those farther out, and all on the domain's boundary, have that
/// field exactly; the row then reads −ln(r_e)/2π. This sees the shape of the tets and where in them
/// the line runs, which a multiple of the mean edge (kWellC h, the answer where the tets are too
/// poor to tell) does not: docs/algorithms/tissue_fields.md.
///
/// The domain's stiffness is made when it is first asked for. Safe to use from several threads.
/// Keeps a reference to the domain.
class WellSolver {
 public:
  explicit WellSolver(const domain::Domain& domain);
  ~WellSolver();
  WellSolver(WellSolver&&) noexcept;
  WellSolver& operator=(WellSolver&&) noexcept;

  /// @param tangent     of the line, unit
  /// @param h           mean edge of the row's tet [m]
  /// @param coreRadius  vertices nearer to the line than this have its field at this distance [m]
  [[nodiscard]] Well around(const WellPoint& point, const mesh::Vector3& tangent, double h,
                            double coreRadius) const;
  /// The radius alone [m], of several rows that share the flux of one line, each on a line of its
  /// own: their mean reading.
  [[nodiscard]] double radius(std::span<const WellPoint> points, const mesh::Vector3& tangent,
                              double h) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// How far around a row the tets are solved, in mean edges [unitless].
inline constexpr double kWellReach = 1.5;
/// Nearer to the line than this, in mean edges, linear functions cannot follow the logarithm
/// anyway [unitless].
inline constexpr double kNearLine = 0.2;
/// A well radius is kept between this many times the guess and one over it [unitless].
inline constexpr double kLeastWell = 0.3;

}  // namespace ecorche::tissue
