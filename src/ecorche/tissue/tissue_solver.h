#pragma once

#include <ecorche/mesh/cholesky.h>
#include <ecorche/tissue/tissue_fields.h>

#include <memory>
#include <span>
#include <vector>

namespace ecorche::tissue {

/// One smooth field per muscle and filler and one for fat; the largest owns the point.
///
/// Minimises the Dirichlet energy with curves as soft constraints [ABLSJ21 §3.3, §3.4, §3.7]; the
/// rows and weights are those of `cores`. Fields are 0 on skin (fat: its value there) and free on
/// bones and cut planes.
///
/// @param domain   tagged tets; every component of it needs skin or a curve
/// @param cores    rows of every curve, from traceCurves with the same tissues and options
/// @return  fields, unchanged when the model is moved, turned or uniformly scaled; permuting the
/// tissues permutes them;
///          how far they leave [0, largest value] on poor tets is in the result. The same bytes on
///          any number of threads, unless options say otherwise.
/// @errors  ComponentWithoutSkin (and without curve), SystemSingular (with the place), Cancelled
///
/// Costs one analysis and one factorisation for fat and all isotropic tissues, and one more
/// factorisation per anisotropic one.
[[nodiscard]] Result<TissueFields> solveTissueFields(const domain::Domain& domain,
                                                     const CoreSamples& cores,
                                                     const std::vector<CurveTissue>& tissues,
                                                     const TissueOptions& options, RunContext& run);

/// The field of an anisotropic tissue, where it is something.
struct OwnSolution {
  std::size_t tissue = 0;
  std::span<const std::int32_t> row;  ///< of the solver's pattern
  Eigen::Ref<const Eigen::VectorXd> values;
};

/// What can be done once per domain: energies, sparsity, ordering. Answers any number of tissue
/// lists after that.
class TissueSolver {
 public:
  /// What fat and all isotropic tissues share while no curve moves, kept for more right-hand sides.
  using Factor = std::shared_ptr<const mesh::Cholesky>;

  /// Keeps a reference to the domain, which must outlive the solver.
  /// @errors  Cancelled
  [[nodiscard]] static Result<TissueSolver> create(const domain::Domain& domain, RunContext& run);
  TissueSolver(TissueSolver&&) noexcept;
  TissueSolver& operator=(TissueSolver&&) noexcept;
  ~TissueSolver();

  /// As solveTissueFields. Safe from several threads.
  [[nodiscard]] Result<TissueFields> solve(const CoreSamples& cores,
                                           const std::vector<CurveTissue>& tissues,
                                           const TissueOptions& options, RunContext& run) const;

  /// @errors  ComponentWithoutSkin (and without curve), SystemSingular (with the place), Cancelled
  [[nodiscard]] Result<Factor> factorise(const CoreSamples& cores, const TissueOptions& options,
                                         RunContext& run) const;
  /// As solve, with the factor of the same curves and options.
  [[nodiscard]] Result<TissueFields> solve(const Factor& factor, const CoreSamples& cores,
                                           const std::vector<CurveTissue>& tissues,
                                           const TissueOptions& options, RunContext& run) const;
  /// Fields of one tissue for other targets, as they come from the equations: nothing corrected
  /// near curves.
  /// @param targets  #samples×k, the tissue's value at its own samples; others are not looked at
  /// @return  #V×k, 0 on skin
  /// @errors  SystemSingular, Cancelled
  [[nodiscard]] Result<Eigen::MatrixXd> solveTargets(const Factor& factor, const CoreSamples& cores,
                                                     const std::vector<CurveTissue>& tissues,
                                                     std::size_t tissue,
                                                     const Eigen::MatrixXd& targets,
                                                     RunContext& run) const;
  /// What the curves leave of fat: 1 on skin, as it comes from the equations, #V×1.
  [[nodiscard]] Eigen::MatrixXd solveFat(const Factor& factor, const CoreSamples& cores) const;

  [[nodiscard]] const domain::Domain& domain() const;
  /// Of every matrix that it factors: rows are the vertices that are not skin.
  [[nodiscard]] const mesh::StiffnessPattern& pattern() const;
  /// Isotropic energy of the fields, without curves, on the pattern.
  [[nodiscard]] const std::vector<double>& stiffness() const;
  /// @errors  SystemSingular where nothing holds a part of the domain, as solve tells it
  [[nodiscard]] Result<void> checkHeld(const CoreSamples& cores) const;
  /// Null where every vertex is skin.
  [[nodiscard]] const mesh::SymbolicCholesky* symbolic() const;
  /// Fields from solutions of their equations, corrected near curves.
  /// @param X    #rows×(#isotropic tissues + 1): column 0 of all curves at 1, which gives fat, then
  /// one per isotropic tissue
  /// @param own  those of anisotropic tissues, by tissue
  /// @errors  SystemSingular where a number is not finite
  [[nodiscard]] Result<TissueFields> fieldsOf(const FieldMatrix& X,
                                              const std::vector<OwnSolution>& own,
                                              const CoreSamples& cores,
                                              const std::vector<CurveTissue>& tissues,
                                              const TissueOptions& options) const;
  /// Entries of the factor, for reports.
  [[nodiscard]] double factorEntries() const;

 private:
  struct Impl;
  explicit TissueSolver(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::tissue
