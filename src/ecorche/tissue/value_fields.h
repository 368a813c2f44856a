#pragma once

#include <ecorche/domain/domain.h>
#include <ecorche/tissue/curve_drag.h>
#include <ecorche/tissue/settling.h>
#include <ecorche/tissue/tissue_solver.h>

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <vector>

namespace ecorche::tissue {

/// Fields that follow tissue values and fat at once, while no curve moves.
///
/// Fields are linear in the values: f_i = Σ_p D_p φ_p, φ_p the field of a value 1 at control point
/// p and 0 at all others, and f_fat = d_fat φ_fat (docs/algorithms/tissue_fields.md). The function
/// φ_p is solved for when p is first edited, with the factor that solved the fields; from then on
/// its value costs a few passes over the vertices. A tissue whose values all grow by one factor
/// needs none. Owners come along: a tissue's field is compared with the largest of the others,
/// which is looked for once whenever another tissue is edited.
///
/// After any edits of values and fat, fields are those of a solve from scratch, to rounding. Curves
/// may be moved, too: fields follow within a frame, good enough to look at, until somebody has
/// solved for them.
class ValueFields {
 public:
  /// Solves the fields. Keeps the solver and everything else that it is given.
  /// @errors  those of TissueSolver::solve
  [[nodiscard]] static Result<ValueFields> create(std::shared_ptr<const domain::Domain> domain,
                                                  std::shared_ptr<const TissueSolver> solver,
                                                  CoreSamples cores,
                                                  std::vector<CurveTissue> tissues,
                                                  TissueOptions options, RunContext& run,
                                                  std::shared_ptr<const CurveWalker> walker = {});
  /// Of what has been settled.
  [[nodiscard]] static ValueFields create(std::shared_ptr<const domain::Domain> domain,
                                          std::shared_ptr<const TissueSolver> solver,
                                          Settling::Settled settled, CoreSamples cores,
                                          std::vector<CurveTissue> tissues, TissueOptions options,
                                          std::shared_ptr<const CurveWalker> walker = {});
  /// The same by what is left to do since `settling` last solved.
  [[nodiscard]] static Result<ValueFields> create(std::shared_ptr<const domain::Domain> domain,
                                                  Settling& settling, CoreSamples cores,
                                                  std::vector<CurveTissue> tissues,
                                                  TissueOptions options, RunContext& run,
                                                  std::shared_ptr<const CurveWalker> walker = {});
  ValueFields(ValueFields&&) noexcept;
  ValueFields& operator=(ValueFields&&) noexcept;
  ~ValueFields();

  [[nodiscard]] const TissueFields& fields() const;
  [[nodiscard]] const domain::Domain& domain() const;
  [[nodiscard]] const CoreSamples& cores() const;
  [[nodiscard]] const std::vector<CurveTissue>& tissues() const;
  [[nodiscard]] const std::vector<TissueId>& owners() const;  ///< #V
  [[nodiscard]] double fat() const;                           ///< value on skin [unitless]

  /// What an edit changed.
  struct Changed {
    /// Where the owner is another one, or the field has gone on by more than kTold (of a moved
    /// curve: MovedFields::kToldMoved) since it was last told, ascending: what a picture has to
    /// take anew.
    std::vector<std::int32_t> vertices;
    std::int64_t owners = 0;           ///< at how many of them the owner is another one
    std::vector<std::int32_t> fields;  ///< columns that changed
    double error =
        0.0;  ///< of moved curves, over the largest value: what is left to do is of its size
  };
  static constexpr double kTold = 1e-5;  ///< of the largest value

  /// φ of so many tissues are kept; those edited longest ago are forgotten.
  static constexpr std::size_t kReady = 4;

  /// All values of one tissue.
  /// @param values  one list per curve, one value per control point [unitless, > 0]
  /// @errors  SystemSingular, Cancelled: nothing has changed
  [[nodiscard]] Result<Changed> setValues(std::size_t tissue,
                                          const std::vector<std::vector<double>>& values,
                                          RunContext& run);
  /// @param fat  value on skin [unitless, ≥ 0]; 0: fat owns nothing
  [[nodiscard]] Changed setFat(double fat);

  struct CurveMove {
    CurveRef curve;
    mesh::Spline spline;  ///< as many points as before
  };
  /// Curves that a hand moves (curve_drag.h). Those moved before stay where they were left. Fields
  /// of anisotropic tissues follow where they were settled by a Settling; else they stay as they
  /// are. Values and fat cannot be edited from then on.
  [[nodiscard]] Changed moveCurves(const std::vector<CurveMove>& moves);
  /// What moving these curves needs, made before the first frame asks for it; of none, what moving
  /// any does.
  void prepareMove(const std::vector<CurveRef>& curves);
  /// Whether curves have been moved since the fields were solved.
  [[nodiscard]] bool isAdrift() const;

 private:
  struct Impl;
  explicit ValueFields(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::tissue
