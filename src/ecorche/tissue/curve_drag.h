#pragma once

#include <ecorche/mesh/spline.h>
#include <ecorche/tissue/curve_walk.h>
#include <ecorche/tissue/drag_ground.h>
#include <ecorche/tissue/tissue_fields.h>

#include <functional>
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

/// How closely drags follow (docs/algorithms/interactive.md). Shares are of the largest tissue
/// value.
struct DragOptions {
  /// Fields that change by less are left as they are, and so is every vertex where all would.
  double tolerance = 0.004;
  /// The flux along a curve is linear between so many places.
  int knots = 30;
  /// Over the tets near the curve, where it was and where it is.
  int sweeps = 8;
};

/// Fields that follow curves under the hand, within a frame and good enough to look at.
///
/// Only the rows of the moved curves change: K' = K − B_oᵀ W_o B_o + B_nᵀ W_n B_n. The factor of K
/// stays. What old rows read and what new ones pull is smooth along a curve, so some thirty hats
/// stand for hundreds of rows: a small Woodbury system, whose columns go down the elimination tree
/// from the curve to the root alone and come back where they matter (mesh/tree_solver.h). What that
/// misses is local: a few Gauss–Seidel sweeps over the tets near the curves (tube_sweeps.h). See
/// docs/algorithms/interactive.md for what was measured.
///
/// Every frame begins at the settled fields: nothing piles up.
class CurveDrag {
 public:
  /// Values of all fields at a vertex, as the equations gave them, fat first.
  using RawRow = std::function<const double*(std::int32_t vertex)>;

  /// @param ground   of the settled fields; kept
  /// @param walker   of the same domain; kept by reference
  /// @param moved    curves of isotropic tissues that the hand moves
  /// @param raw      settled, must answer as long as this lives
  CurveDrag(std::shared_ptr<DragGround> ground, const CurveWalker& walker, const CoreSamples& cores,
            const std::vector<CurveTissue>& tissues, const TissueOptions& options,
            std::vector<CurveRef> moved, RawRow raw, DragOptions how = {});
  ~CurveDrag();
  CurveDrag(CurveDrag&&) noexcept;
  CurveDrag& operator=(CurveDrag&&) noexcept;

  [[nodiscard]] const std::vector<CurveRef>& moved() const;
  /// Fields that stay as they are settled: those of anisotropic tissues.
  [[nodiscard]] const std::vector<Eigen::Index>& frozen() const;

  /// What is other than settled.
  struct Frame {
    std::vector<std::int32_t> vertices;
    std::vector<std::int32_t> fields;  ///< columns of TissueFields::values
    Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>
        change;                         ///< #vertices×#fields, to raw values
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
