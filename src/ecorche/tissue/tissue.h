#pragma once

#include <ecorche/core/ids.h>
#include <ecorche/mesh/spline.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::tissue {

/// How fast a muscle's field spreads across its curve; along the curve it spreads with 1 [ABLSJ21
/// §3.7].
struct Anisotropy {
  double lambda2 = 1.0;   ///< along e2. 1: isotropic [unitless, > 0]
  double lambda3 = 1.0;   ///< along e3. 1: isotropic [unitless, > 0]
  double rotation = 0.0;  ///< of e2, e3 about the tangent at the curve's first point [rad]
  [[nodiscard]] bool isIsotropic() const { return lambda2 == 1.0 && lambda3 == 1.0; }
  bool operator==(const Anisotropy&) const = default;
};

/// One head of a muscle.
struct TissueCurve {
  std::string name;            ///< for messages: "biceps femoris, curve 2"
  mesh::Spline spline;         ///< world [m], origin first
  std::vector<double> values;  ///< tissue value at each control point [unitless, > 0]
  bool operator==(const TissueCurve&) const = default;
};

/// A tissue that grows from curves: a muscle, or a filler that takes space and is not exported as a
/// muscle. Its id is kFirstMuscle + its place in the list.
struct CurveTissue {
  std::string name;
  bool filler = false;
  std::vector<TissueCurve> curves;
  std::optional<double> coreRadius;  ///< [m]. Unset: TissueOptions::coreRadius
  Anisotropy anisotropy;

  [[nodiscard]] double largestValue() const {
    double most = 0.0;
    for (const TissueCurve& curve : curves) {
      for (const double value : curve.values) most = std::max(most, value);
    }
    return most;
  }
  bool operator==(const CurveTissue&) const = default;
};

/// What the energies are weighed with, and how they are minimised.
struct TissueOptions {
  double fat = 0.3;  ///< value of the fat field on skin. 0: fat is no candidate [unitless]
  std::optional<double> coreRadius;  ///< [m]. Unset: 0.1 % of the skin's diagonal
  std::optional<double>
      alpha;  ///< the paper's constant row weight instead of well weights, for comparison
  /// Of BLAS in the factorisation that all tissues share. 1: the same bytes on any number of
  /// threads; 0: as many as the process was given, for last bits that nobody keeps.
  int factorThreads = 1;
  bool operator==(const TissueOptions&) const = default;
};

}  // namespace ecorche::tissue
