#pragma once

#include <ecorche/tissue/drag_ground.h>
#include <ecorche/tissue/drag_rows.h>
#include <ecorche/tissue/field_region.h>
#include <ecorche/tissue/spread_tensors.h>

#include <Eigen/Core>
#include <array>
#include <functional>
#include <memory>
#include <vector>

namespace ecorche::tissue {

/// An anisotropic tissue's own equations, settled, in the region where its field is something.
struct OwnGround {
  /// xx yy zz xy xz yz of a symmetric tensor.
  using Tensor = std::array<float, 6>;
  /// TensorEntries on the region's rows.
  using Spread = Eigen::Matrix<float, Eigen::Dynamic, kTensorEntries, Eigen::RowMajor>;

  std::shared_ptr<const FieldRegion> region;
  std::shared_ptr<const DragGround> ground;  ///< on the region's pattern
  std::vector<Tensor> medium;                ///< of every tet of the region
  Spread spread;                             ///< that the medium was made of
  std::vector<CoreSample>
      own;  ///< the tissue's rows, as rowsOf tells them, weights to the last bit

  /// Rows that lie in the region, told by its tets and weighed in this medium.
  [[nodiscard]] std::vector<CoreSample> rowsOf(const std::vector<CoreSample>& samples) const;
  /// The same, piece by piece; pieces without a row here are none. Nothing is near them.
  [[nodiscard]] PiecedRows rowsOf(const PiecedRows& rows) const;
  /// The field for other targets; K is factored for it in 64 bits.
  /// @param targets  #own×k
  /// @return  #rows of the region × k
  [[nodiscard]] Eigen::MatrixXd solve(const Eigen::MatrixXd& targets) const;
};

/// Whose they are.
struct OwnEquations {
  std::size_t tissue = 0;
  std::shared_ptr<const OwnGround> ground;
};

/// The equations that fat and isotropic tissues share, for what is spread by them.
struct SharedEquations {
  const std::vector<double>& K;  ///< on the solver's pattern
  /// In 64 bits, made when it is first asked for. Asked from several threads.
  std::function<const mesh::Cholesky&()> factor;
  std::shared_ptr<const FieldRegion> whole;  ///< all of the domain; null: who needs it makes it
};

/// The field of one anisotropic tissue while a project is edited: its matrix is its own, but counts
/// only where its field is more than 10⁻¹¹ of its largest value. What comes out is what
/// TissueSolver::solve gives, to 5·10⁻⁹ of that.
///
/// The region is found by a first solve in all of the domain, and again when the field has reached
/// its rim.
class OwnField {
 public:
  OwnField();
  OwnField(OwnField&&) noexcept;
  OwnField& operator=(OwnField&&) noexcept;
  ~OwnField();

  [[nodiscard]] static std::shared_ptr<const FieldRegion> wholeOf(const TissueSolver& solver);

  enum class Outcome : std::uint8_t { Done, Stopped, Singular };
  /// @return  not Done: what was there stays
  [[nodiscard]] Outcome solve(const TissueSolver& solver, const SharedEquations& shared,
                              const CoreSamples& cores, const CurveTissue& tissue, TissueId id,
                              const std::function<bool()>& stop);
  /// Null before the first solve.
  [[nodiscard]] const std::shared_ptr<const OwnGround>& ground() const;
  /// On the region's rows.
  [[nodiscard]] const Eigen::VectorXd& values() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::tissue
