#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/core_rim.h>
#include <ecorche/tissue/piece_rows.h>
#include <ecorche/tissue/well.h>

namespace ecorche::tissue {

using domain::Domain;
using mesh::Vector3;

namespace {

// The weight shared by points on the core's rim, where the field of the line is what the core holds
void addRim(const CurveWalker& walker, const Domain& domain, const CoreSample& middle,
            const Vector3& centre, double rho, double line, std::vector<CoreSample>& out) {
  const std::vector<WellPoint> points = rimPoints(walker, domain, middle, centre, rho);
  // Solving pays while a tet is about as large as the core; much finer ones see the rim as it is
  constexpr double kFineTets = 0.4;
  const double h = walker.meanEdges()[middle.tet];
  const double radius = h > kFineTets * rho ? walker.wells().radius(points, middle.tangent, h)
                                            : rimRadius(rho, line, static_cast<int>(points.size()));
  addRimRows(domain, middle, points, wellResistance(rho, radius), out);
}

}  // namespace

PieceRows rowsOfPiece(const CurveWalker& walker, const Domain& domain, const mesh::Spline& spline,
                      const CurvePiece& piece, TissueId tissue, std::int32_t curve, double rho,
                      std::optional<double> alpha) {
  PieceRows out;
  out.length = spline.lengthBetween(piece.u0, piece.u1);
  if (!(out.length > 0.0)) return out;
  CoreSample sample;
  sample.tissue = tissue;
  sample.curve = curve;
  sample.tet = piece.tet;
  sample.u = spline.halfway(piece.u0, piece.u1);
  sample.length = out.length;
  sample.tangent = spline.tangent(sample.u);
  out.middle = spline.at(sample.u);
  // The chord stood for the curve: pull the middle of a bent piece back into its tet
  const Eigen::Vector4d b = mesh::barycentric(domain.mesh, piece.tet, out.middle).cwiseMax(0.0);
  sample.barycentric = b / b.sum();
  if (alpha) {
    sample.weight = *alpha;
    out.samples.push_back(sample);
    return out;
  }
  const double h = walker.meanEdges()[piece.tet];
  Well well = walker.wells().around({out.middle, piece.tet}, sample.tangent, h, rho);
  if (well.radius >= rho) {
    sample.weight = wellWeight(rho, well.radius) * sample.length;
    out.samples.push_back(sample);
    out.well = std::move(well);
  } else {
    addRim(walker, domain, sample, out.middle, rho, well.radius, out.samples);
  }
  return out;
}

}  // namespace ecorche::tissue
