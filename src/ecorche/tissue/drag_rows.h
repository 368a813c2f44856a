#pragma once

#include <ecorche/tissue/curve_walk.h>
#include <ecorche/tissue/tissue_fields.h>

#include <functional>
#include <span>
#include <vector>

namespace ecorche::tissue {

/// Rows that stand for one piece of one curve: a single one, or several on the core's rim.
struct RowPiece {
  std::int32_t first = 0;  ///< of its samples
  std::int32_t count = 0;
  double length = 0.0;  ///< [m]
  double target = 0.0;  ///< tissue value there [unitless]
};

/// Rows of curves, piece by piece.
struct PiecedRows {
  std::vector<CoreSample> samples;
  std::vector<RowPiece> pieces;
  std::vector<NearCurve> nearCurves;   ///< by curve; vertices may come up for several
  std::vector<std::int32_t> curveEnd;  ///< past the last piece of each curve
};

/// Settled values of all fields at a vertex of the domain, as the equations gave them, fat first.
using RawRow = std::function<const double*(std::int32_t vertex)>;

/// Takes in rows of one more curve as traceCurves made them.
void addPieces(const CurveTissue& tissue, std::span<const CoreSample> samples, PiecedRows& rows);

/// Takes in rows of one more curve as traceCurves makes them, but that what lies outside the domain
/// is left out without a word.
/// @param curve  within its tissue, at `spline` now
void addDragged(const CurveWalker& walker, const domain::Domain& domain, const CurveTissue& tissue,
                TissueId id, std::int32_t curve, const mesh::Spline& spline,
                const TissueOptions& options, PiecedRows& rows);

}  // namespace ecorche::tissue
