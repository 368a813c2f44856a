#pragma once

#include <ecorche/tissue/tissue_fields.h>

#include <span>

namespace ecorche::tissue {

/// Takes off the fields what linear functions make wrong of a line's logarithm.
///
/// Tets that are as wide as a muscle cannot follow the field near its curve: with the flux right,
/// vertices beside the curve are still some percent too low, the more so the coarser the tets, and
/// muscles too thin. How much a line of unit flux is off there is known (WellSolver), and so is the
/// flux that each row sends into, or takes out of, every field: W/ℓ (δ_ij D_i − B f_j)
/// (docs/algorithms/tissue_fields.md). In an anisotropic medium weight and resistance of a line
/// change by the same factor, so the same product is used there; that the tets are stretched in its
/// metric is left aside.
///
/// No value is taken below 0, nor in its own field above D_i, unless it lies there already: where
/// other curves run within a patch, a lone line is no guide.
///
/// @param targets  tissue value at every sample
/// @param values   solved fields, all rows
/// @return  the rows that were corrected, as they were
UncorrectedRows correctNearCurves(const domain::Domain& domain, const CoreSamples& cores,
                                  std::span<const double> targets, FieldMatrix& values);
/// Of one value, given the flux of the line nearby into the field.
/// @param off     flux times NearCurve::error
/// @param own     whether the field is the line's own
/// @param target  tissue value there
[[nodiscard]] double correctedNearCurve(double f, double off, bool own, double target);
/// The same for one field alone, #V.
/// @param targets  tissue value at the samples of `field`; others are not looked at
void correctNearCurves(const domain::Domain& domain, const CoreSamples& cores,
                       Eigen::Ref<const Eigen::VectorXd> targets, TissueId field,
                       Eigen::Ref<Eigen::VectorXd> f);

}  // namespace ecorche::tissue
