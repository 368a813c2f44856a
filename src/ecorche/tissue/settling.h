#pragma once

#include <ecorche/tissue/drag_ground.h>
#include <ecorche/tissue/own_field.h>
#include <ecorche/tissue/tissue_solver.h>

#include <memory>
#include <vector>

namespace ecorche::tissue {

/// Solves for fields again and again while a project is edited, by what is left to do since the
/// last time: the factor is made anew where the matrix is another one (mesh/single_cholesky.h), and
/// fields go on from where they were (refined_solve.h). What comes out is what TissueSolver::solve
/// gives, to 5·10⁻⁹ of the largest value.
///
/// Anisotropic tissues are solved for beside each other, where their fields are something
/// (own_field.h). What 32 bits are too few for is solved by TissueSolver as a whole.
class Settling {
 public:
  explicit Settling(std::shared_ptr<const TissueSolver> solver);
  Settling(Settling&&) noexcept;
  Settling& operator=(Settling&&) noexcept;
  ~Settling();

  [[nodiscard]] const std::shared_ptr<const TissueSolver>& solver() const;

  struct Settled {
    TissueFields fields;
    TissueSolver::Factor factor;         ///< where it was solved as a whole; else null
    std::shared_ptr<DragGround> ground;  ///< else this, which drags stand on
    std::vector<OwnEquations> own;       ///< and these, one per anisotropic tissue
    Eigen::MatrixXd fat;       ///< as TissueSolver::solveFat gives it, where there is ground
    int passes = 0;            ///< of refinement
    Eigen::Index leftOut = 0;  ///< fields so little changed that most rows were not looked at
    double factored = 0.0;     ///< share of the factor that was made anew
  };
  /// @errors  those of TissueSolver::solve; what was there stays
  [[nodiscard]] Result<Settled> solve(const CoreSamples& cores,
                                      const std::vector<CurveTissue>& tissues,
                                      const TissueOptions& options, RunContext& run);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::tissue
