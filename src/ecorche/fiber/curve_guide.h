#pragma once

#include <ecorche/fiber/muscle_mesh.h>
#include <ecorche/tissue/tissue.h>

#include <limits>
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
  /// What flows through a curve's share of the muscle: its mean cross-section, volume over length,
  /// so that the flow's density is about 1 everywhere [m²].
  [[nodiscard]] double flux(std::int32_t curve) const;
  [[nodiscard]] double distance(std::int32_t curve, const mesh::Vector3& x) const;  ///< [m]

 private:
  /// A point of a line: segment, share of it, and the squared distance to it [m²].
  struct Place {
    double squared = std::numeric_limits<double>::infinity();
    std::size_t segment = 0;
    double share = 0.0;
  };
  struct Line {
    bool improve(const mesh::Vector3& x, Place& best) const;
    std::vector<mesh::Vector3> point;
    std::vector<mesh::Vector3> step;  // per segment
    std::vector<double> perStep;      // 1 / |step|²
    std::vector<double> arc;
    std::vector<mesh::Vector3> tangent;  // at points
    std::vector<double> radius;          // per bin of equal arc length
    double flux = 0.0;
    // Balls about runs of segments, to skip runs that are too far
    std::vector<mesh::Vector3> ballCentre;
    std::vector<double> ballRadius;
  };
  std::vector<Line> lines_;
};

}  // namespace ecorche::fiber
