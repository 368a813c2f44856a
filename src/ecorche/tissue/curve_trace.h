#pragma once

#include <ecorche/tissue/curve_walk.h>
#include <ecorche/tissue/tissue_fields.h>

namespace ecorche::tissue {

/// Rows of B with their weights: one per tet that a curve crosses, at the middle of the piece
/// [ABLSJ21 §3.4], weighted by its length and the well weight of docs/algorithms/tissue_fields.md.
/// Where tets are finer than the core, a row is spread over points of the core's rim.
/// TissueOptions::alpha gives the paper's constant weight instead.
///
/// A curve may run through bone, obstacles, cavities and cut planes: what is lost there is a
/// Finding and lowers coveredShare. Ends, or bulges, may lie up to half a percent of the skin's
/// diagonal outside the skin.
///
/// @param tissues  ids count from kFirstMuscle in this order
/// @errors  MuscleWithoutCurve, ZeroLengthCurve, CurveOutsideDomain (nothing of it inside),
/// CurveOutsideSkin (with the
///          point farthest out), Cancelled
[[nodiscard]] Result<CoreSamples> traceCurves(const domain::Domain& domain,
                                              const std::vector<CurveTissue>& tissues,
                                              const TissueOptions& options, RunContext& run);
/// The same with a walker that is kept between edits.
[[nodiscard]] Result<CoreSamples> traceCurves(const CurveWalker& walker,
                                              const domain::Domain& domain,
                                              const std::vector<CurveTissue>& tissues,
                                              const TissueOptions& options, RunContext& run);

/// Traces kept between edits, for one domain and one walker: a curve that has not moved is not
/// traced again.
class KeptTraces {
 public:
  KeptTraces();
  KeptTraces(KeptTraces&&) noexcept;
  KeptTraces& operator=(KeptTraces&&) noexcept;
  ~KeptTraces();

  struct Entry;  ///< one curve and what became of it

 private:
  friend Result<CoreSamples> traceCurves(const CurveWalker&, const domain::Domain&,
                                         const std::vector<CurveTissue>&, const TissueOptions&,
                                         RunContext&, KeptTraces&);
  std::vector<Entry> entries_;
};
/// The same to the last bit, from what is kept where that will do; keeps what it made.
[[nodiscard]] Result<CoreSamples> traceCurves(const CurveWalker& walker,
                                              const domain::Domain& domain,
                                              const std::vector<CurveTissue>& tissues,
                                              const TissueOptions& options, RunContext& run,
                                              KeptTraces& kept);

/// How far outside the skin a curve may reach, over the skin's diagonal [unitless].
inline constexpr double kOutsideTolerance = 0.005;

/// ρ of a tissue: its own, the options', or 0.1 % of the skin's diagonal [m].
[[nodiscard]] double coreRadius(const CurveTissue& tissue, const TissueOptions& options,
                                const domain::Domain& domain);

}  // namespace ecorche::tissue
