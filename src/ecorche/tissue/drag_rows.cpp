#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/drag_rows.h>
#include <ecorche/tissue/nearest_samples.h>
#include <ecorche/tissue/piece_rows.h>
#include <ecorche/tissue/sample_targets.h>

namespace ecorche::tissue {

void addPieces(const CurveTissue& tissue, std::span<const CoreSample> samples, PiecedRows& rows) {
  for (std::size_t i = 0; i < samples.size();) {
    const CoreSample& sample = samples[i];
    RowPiece piece;
    piece.first = static_cast<std::int32_t>(rows.samples.size());
    piece.target = sampleTarget(tissue, sample);
    // Rows of one rim are of one place on the curve
    for (; i < samples.size() && samples[i].u == sample.u && samples[i].curve == sample.curve;
         ++i) {
      ++piece.count;
      piece.length += samples[i].length;
      rows.samples.push_back(samples[i]);
    }
    rows.pieces.push_back(piece);
  }
  rows.curveEnd.push_back(static_cast<std::int32_t>(rows.pieces.size()));
}

void addDragged(const CurveWalker& walker, const domain::Domain& domain, const CurveTissue& tissue,
                TissueId id, std::int32_t curve, const mesh::Spline& spline,
                const TissueOptions& options, PiecedRows& rows) {
  const std::vector<double>& values = tissue.curves[static_cast<std::size_t>(curve)].values;
  EC_REQUIRE_EQ(values.size(), spline.points().size());
  const double rho = coreRadius(tissue, options, domain);
  const CurveWalk walk = walker.walk(spline);
  std::vector<PieceRows> made(walk.pieces.size());
  parallelFor(
      std::ssize(made),
      [&](std::int64_t i) {
        made[static_cast<std::size_t>(i)] =
            rowsOfPiece(walker, domain, spline, walk.pieces[static_cast<std::size_t>(i)], id, curve,
                        rho, options.alpha);
      },
      kPieceGrain);
  NearestSamples nearest;
  for (const PieceRows& m : made) {
    if (m.samples.empty()) continue;
    const auto first = static_cast<std::int32_t>(rows.samples.size());
    nearest.add(domain, m.well, m.middle, first);
    rows.pieces.push_back({first, static_cast<std::int32_t>(m.samples.size()), m.length,
                           spline.interpolate(values, m.samples.front().u)});
    rows.samples.insert(rows.samples.end(), m.samples.begin(), m.samples.end());
  }
  rows.curveEnd.push_back(static_cast<std::int32_t>(rows.pieces.size()));
  const std::vector<NearCurve> near = nearest.byVertex();
  rows.nearCurves.insert(rows.nearCurves.end(), near.begin(), near.end());
}

}  // namespace ecorche::tissue
