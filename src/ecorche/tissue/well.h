#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ecorche::tissue {

/// How hard a curve holds on to its value: π β per length, before what the tet cannot resolve is
/// taken off [unitless].
inline constexpr double kWellBeta = 5.0;
/// Equivalent radius of a tet over its mean edge: where the field of a line equals what the tet's
/// row reads. Calibrated in docs/algorithms/tissue_fields.md [unitless].
inline constexpr double kWellC = 0.4;

/// Weight per length of a core of radius ρ in tets of size h: 1/w = 1/(πβ) + ln(max(c h, ρ)/ρ) / 2π
/// [Peaceman 1978] [unitless].
[[nodiscard]] inline double wellWeight(double coreRadius, double h, double c = kWellC) {
  const double resolved = std::max(c * h, coreRadius);
  return 1.0 / (1.0 / (std::numbers::pi * kWellBeta) +
                std::log(resolved / coreRadius) / (2.0 * std::numbers::pi));
}

}  // namespace ecorche::tissue
