#pragma once

#include <ecorche/tissue/curve_walk.h>
#include <ecorche/tissue/tissue_fields.h>
#include <ecorche/tissue/well_radius.h>

#include <optional>
#include <vector>

namespace ecorche::tissue {

/// What stands for a piece of curve in one tet: one row at its middle, or several on the core's rim
/// where tets are finer than the core.
struct PieceRows {
  std::vector<CoreSample> samples;               ///< none where the piece has no length
  mesh::Vector3 middle = mesh::Vector3::Zero();  ///< [m]
  double length = 0.0;                           ///< [m]
  Well well;                                     ///< of a single row; of a rim it knows nothing
};

/// So many pieces are a task's worth.
inline constexpr std::int64_t kPieceGrain = 8;

/// @param tissue  and `curve`, within it: what rows are told of
/// @param rho     core radius [m]
/// @param alpha   weight of every row, in place of that of its well [unitless]
[[nodiscard]] PieceRows rowsOfPiece(const CurveWalker& walker, const domain::Domain& domain,
                                    const mesh::Spline& spline, const CurvePiece& piece,
                                    TissueId tissue, std::int32_t curve, double rho,
                                    std::optional<double> alpha);

}  // namespace ecorche::tissue
