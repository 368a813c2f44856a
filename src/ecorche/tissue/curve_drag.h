#pragma once

#include <ecorche/mesh/spline.h>
#include <ecorche/tissue/curve_walk.h>
#include <ecorche/tissue/drag_system.h>
#include <ecorche/tissue/own_field.h>

#include <memory>
#include <span>
#include <vector>

namespace ecorche::tissue {

/// Which curve of which tissue.
struct CurveRef {
  std::size_t tissue = 0;
  std::int32_t curve = 0;
  friend bool operator==(const CurveRef&, const CurveRef&) = default;
};

/// Equations that drags stand on, settled.
struct DragGrounds {
  std::shared_ptr<const DragGround> shared;  ///< of fat and isotropic tissues
  std::vector<OwnEquations> own;             ///< of anisotropic ones; a tissue without: stays
};

/// Fields that follow curves under the hand, within a frame and good enough to look at: those of
/// fat and isotropic tissues in the equations that they share (drag_system.h), those of anisotropic
/// ones each in its own, whose medium stays as it was settled unless the hand moves its own curves
/// (own_drag.h).
class CurveDrag {
 public:
  /// @param grounds  of the settled fields; kept
  /// @param walker   of `domain`; both kept by reference
  /// @param moved    curves that the hand moves
  /// @param raw      settled, must answer as long as this lives
  CurveDrag(const domain::Domain& domain, DragGrounds grounds, const CurveWalker& walker,
            const CoreSamples& cores, const std::vector<CurveTissue>& tissues,
            const TissueOptions& options, std::vector<CurveRef> moved, RawRow raw,
            DragOptions how = {});
  ~CurveDrag();
  CurveDrag(CurveDrag&&) noexcept;
  CurveDrag& operator=(CurveDrag&&) noexcept;

  [[nodiscard]] const std::vector<CurveRef>& moved() const;
  /// Fields that stay as they are settled: of anisotropic tissues without equations. Ascending.
  [[nodiscard]] const std::vector<std::int32_t>& frozen() const;

  /// What is other than settled.
  struct Frame {
    std::vector<std::int32_t> vertices;
    std::vector<std::int32_t> fields;   ///< columns of TissueFields::values
    TubeBlock change;                   ///< #vertices×#fields, to raw values
    std::vector<CoreSample> samples;    ///< of the moved curves, where they are now
    std::vector<double> targets;        ///< tissue value at each
    std::vector<NearCurve> nearCurves;  ///< of the moved curves
    double lastStep = 0.0;  ///< of the sweeps, over the largest value: what is left is of its size
  };
  /// Curves may go anywhere; what lies outside the domain pulls on nothing.
  /// @param splines  of moved(), with as many points as before
  [[nodiscard]] Frame move(std::span<const mesh::Spline> splines);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::tissue
