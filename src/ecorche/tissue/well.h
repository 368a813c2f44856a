#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

namespace ecorche::tissue {

/// How hard a curve holds on to its value: π β per length, before what the tets cannot resolve is
/// taken off [unitless].
inline constexpr double kWellBeta = 5.0;
/// Well radius of a typical tet over its mean edge, calibrated in docs/algorithms/tissue_fields.md
/// [unitless].
inline constexpr double kWellC = 0.41;

/// What lies between a core of radius ρ and what its row reads, the field of a line at radius r_e ≥
/// ρ: 1/w = 1/(πβ) + ln(r_e/ρ) / 2π [Peaceman 1978; D'Angelo & Quarteroni 2008] [unitless].
[[nodiscard]] inline double wellResistance(double coreRadius, double wellRadius) {
  // A rim may read a little inside itself; the weight stays finite down to 0.67 ρ
  const double resolved = std::max(wellRadius, 0.9 * coreRadius);
  return 1.0 / (std::numbers::pi * kWellBeta) +
         std::log(resolved / coreRadius) / (2.0 * std::numbers::pi);
}
/// Weight per length of such a row, w [unitless].
[[nodiscard]] inline double wellWeight(double coreRadius, double wellRadius) {
  return 1.0 / wellResistance(coreRadius, wellRadius);
}

/// How many points of the core's rim stand for it where tets are finer than the core: about one per
/// edge of the tets.
[[nodiscard]] inline int rimPointCount(double coreRadius, double h) {
  return std::clamp(static_cast<int>(std::ceil(2.0 * std::numbers::pi * coreRadius / h)), 6, 24);
}

/// Where tets are much finer than the core the rim needs no solving: n lines of flux 1/n around a
/// circle of radius ρ, each smeared over r_e by its tet, so that a row at distance d reads −ln √(d²
/// + r_e²) / 2π; the radius of their mean.
[[nodiscard]] inline double rimRadius(double coreRadius, double wellRadius, int count) {
  const double smear = wellRadius / coreRadius;
  double sum = 0.0;
  for (int k = 0; k < count; ++k) {
    const double chord = 2.0 * std::sin(std::numbers::pi * k / count);
    sum += 0.5 * std::log(chord * chord + smear * smear);
  }
  return coreRadius * std::exp(sum / count);
}

}  // namespace ecorche::tissue
