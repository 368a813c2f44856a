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

/// Weight per length of a core of radius ρ whose row reads the field of a line at radius r_e ≥ ρ:
/// 1/w = 1/(πβ) + ln(r_e/ρ) / 2π [Peaceman 1978; D'Angelo & Quarteroni 2008] [unitless].
[[nodiscard]] inline double wellWeight(double coreRadius, double wellRadius) {
  return 1.0 / (1.0 / (std::numbers::pi * kWellBeta) +
                std::log(std::max(wellRadius, coreRadius) / coreRadius) / (2.0 * std::numbers::pi));
}

/// Points on the rim of a core that the tets resolve, and the radius at which they read the line's
/// field on average.
struct WellRim {
  int count = 6;
  double radius = 0.0;      ///< ρ [m]
  double equivalent = 0.0;  ///< [m], at least ρ
};

/// n lines of flux 1/n around a circle of radius ρ. A tet smears a line over r_e, so a row at
/// distance d reads it as −ln √(d² + r_e²) / 2π: at r_e its own, exactly its distance from afar;
/// the mean over the rim gives the equivalent radius.
[[nodiscard]] inline WellRim wellRim(double coreRadius, double wellRadius) {
  WellRim rim;
  rim.radius = coreRadius;
  // About one point per edge of the tets
  const double edges = 2.0 * std::numbers::pi * coreRadius * kWellC / wellRadius;
  rim.count = std::clamp(static_cast<int>(std::ceil(edges)), 6, 24);
  const double smear = wellRadius / coreRadius;
  double sum = 0.0;
  for (int k = 0; k < rim.count; ++k) {
    const double chord = 2.0 * std::sin(std::numbers::pi * k / rim.count);
    sum += 0.5 * std::log(chord * chord + smear * smear);
  }
  rim.equivalent = std::max(coreRadius, coreRadius * std::exp(sum / rim.count));
  return rim;
}

}  // namespace ecorche::tissue
