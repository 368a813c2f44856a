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
  /// @param moved    isotropic, each once
  MovedFields(const domain::Domain& domain, std::shared_ptr<DragGround> ground,
              const CurveWalker& walker, const CoreSamples& cores,
              const std::vector<CurveTissue>& tissues, const TissueOptions& options,
              std::vector<CurveRef> moved, TissueFields& fields, std::vector<TissueId>& owner);
  ~MovedFields();
  MovedFields(const MovedFields&) = delete;
  MovedFields& operator=(const MovedFields&) = delete;

  [[nodiscard]] const std::vector<CurveRef>& moved() const;

  struct Told {
    std::vector<std::int32_t> vertices;  ///< ascending, whose fields are other ones than before
    std::vector<std::int32_t> fields;    ///< columns that are
    std::int64_t owners = 0;             ///< at how many of them the owner is another one
    double error = 0.0;                  ///< see CurveDrag::Frame::lastStep
  };
  [[nodiscard]] Told move(std::span<const mesh::Spline> splines);
  /// Back to what was settled.
  /// @return  vertices that were another, ascending
  std::vector<std::int32_t> restore();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::tissue
