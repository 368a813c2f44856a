#pragma once

#include <ecorche/fiber/muscle_mesh.h>
#include <ecorche/tissue/tissue.h>

#include <vector>

namespace ecorche::fiber {

/// The curves of one muscle as poly-lines that answer "which curve is nearest, where, and how thick
/// is the muscle".
class CurveGuide {
 public:
  explicit CurveGuide(const tissue::CurveTissue& tissue);

  struct Nearest {
    std::int32_t curve = 0;
    double arc = 0.0;       ///< arc length from the curve's origin [m]
    double distance = 0.0;  ///< [m]
    mesh::Vector3 tangent = mesh::Vector3::UnitX();
  };
  [[nodiscard]] Nearest nearest(const mesh::Vector3& x) const;

  /// Measures the local radius √(area / π) along every curve from the volume of tets nearest to it.
  void measureThickness(const MuscleMesh& muscle, const std::vector<Nearest>& nearestOfTet);

  [[nodiscard]] double radius(std::int32_t curve,
                              double arc) const;          ///< [m], > 0 after measureThickness
  [[nodiscard]] double length(std::int32_t curve) const;  ///< [m]
  [[nodiscard]] std::int32_t curveCount() const { return static_cast<std::int32_t>(lines_.size()); }
  [[nodiscard]] mesh::Vector3 end(std::int32_t curve, bool insertion) const;
  [[nodiscard]] mesh::Vector3 tangentAtEnd(std::int32_t curve,
                                           bool insertion) const;  ///< from origin to insertion
  /// |∇u| at an end of a flow from 0 to 1 that fills the cross-sections: what passes is the same
  /// everywhere [1/m].
  [[nodiscard]] double slopeAtEnd(std::int32_t curve, bool insertion) const;

 private:
  struct Line {
    std::vector<mesh::Vector3> point;
    std::vector<double> arc;
    std::vector<mesh::Vector3> tangent;  // at points
    std::vector<double> radius;          // per bin of equal arc length
    // Balls about runs of segments, to skip runs that are too far
    std::vector<mesh::Vector3> ballCentre;
    std::vector<double> ballRadius;
  };
  std::vector<Line> lines_;
};

}  // namespace ecorche::fiber
