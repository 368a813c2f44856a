#pragma once

#include <ecorche/mesh/spline.h>
#include <ecorche/tissue/drag_system.h>
#include <ecorche/tissue/own_field.h>

#include <memory>
#include <span>
#include <vector>

namespace ecorche::tissue {

/// How closely an anisotropic tissue's field follows its own curves. Shares are of the largest
/// tissue value.
struct OwnDragOptions {
  /// Where the field is less it counts as nothing.
  double negligible = 0.005;
  /// Of the residual, over the right side [unitless].
  double residual = 1e-4;
  int iterations = 200;
};

/// The field of an anisotropic tissue whose curves are under the hand. Its medium goes with them,
/// so nothing of its settled equations holds any longer: it is solved anew in every frame, where it
/// is more than a small share of its largest value. What makes the medium, spread by the equations
/// that all share, comes from a DragSystem of those.
class OwnDrag {
 public:
  /// Entries of the spread, side by side.
  static constexpr int kSpread = kTensorEntries;

  /// @param shared   the equations that spread the medium; kept
  /// @param own      settled; kept
  /// @param staying  rows of all curves that the hand does not move
  /// @param raw      settled fields, fat first; must answer as long as this lives
  /// @param maxValue  largest value of all tissues
  OwnDrag(const domain::Domain& domain, std::shared_ptr<const DragGround> shared,
          std::shared_ptr<const OwnGround> own, CurveTissue tissue, TissueId id,
          std::vector<CoreSample> staying, RawRow raw, double maxValue, OwnDragOptions how = {});
  ~OwnDrag();
  OwnDrag(OwnDrag&&) noexcept;
  OwnDrag& operator=(OwnDrag&&) noexcept;

  [[nodiscard]] std::int32_t field() const;
  /// Curves of the tissue as they are now; what was taken from it before is of no use any more.
  void setCurve(std::int32_t curve, const mesh::Spline& spline);
  /// What rows ask of the spread, in units of its own: 0 where they are another tissue's.
  /// @return  #samples×7
  [[nodiscard]] DragSystem::Targets spreadTargets(const PiecedRows& rows) const;
  /// The spread where the curves are settled, in the same units.
  /// @param out  7 values
  void settledSpread(std::int32_t vertex, double* out) const;

  /// What a DragSystem says that the spread has changed by.
  struct SpreadChange {
    std::span<const std::int32_t> row;  ///< of the shared equations
    std::vector<Eigen::Index> column;   ///< of `change`, for each of seven; −1: none
    const TubeBlock* change = nullptr;
  };
  /// @param now  rows of all curves that the hand moves
  [[nodiscard]] DragSystem::Part move(const PiecedRows& now, std::span<const SpreadChange> spread);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::tissue
