#pragma once

#include <ecorche/tissue/curve_drag.h>

#include <memory>
#include <span>
#include <vector>

namespace ecorche::tissue {

/// Fields and owners while curves are moved: what a drag changes is written over what was settled,
/// and what it no longer changes is put back.
class MovedFields {
 public:
  /// @param domain   of the fields
  /// @param cores    of the settled curves; kept by reference, as walker, fields and owner are
  /// @param moved    each once
  MovedFields(const domain::Domain& domain, DragGrounds grounds, const CurveWalker& walker,
              const CoreSamples& cores, const std::vector<CurveTissue>& tissues,
              const TissueOptions& options, std::vector<CurveRef> moved, TissueFields& fields,
              std::vector<TissueId>& owner);
  ~MovedFields();
  MovedFields(const MovedFields&) = delete;
  MovedFields& operator=(const MovedFields&) = delete;

  [[nodiscard]] const std::vector<CurveRef>& moved() const;

  struct Told {
    /// Ascending: where the owner is another one, or a field has gone on by more than kToldMoved
    /// since it was last told.
    std::vector<std::int32_t> vertices;
    std::vector<std::int32_t> fields;  ///< columns that have gone on there
    std::int64_t owners = 0;           ///< at how many of them the owner is another one
    double error = 0.0;                ///< see CurveDrag::Frame::lastStep
  };
  /// Of the largest value: what moves an interface by a hundredth of a millimetre [unitless].
  static constexpr double kToldMoved = 1e-3;

  [[nodiscard]] Told move(std::span<const mesh::Spline> splines);
  /// Back to what was settled.
  /// @return  all that were another; owners are not counted
  Told restore();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::tissue
