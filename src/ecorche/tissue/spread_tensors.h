#pragma once

#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/tissue_fields.h>

#include <Eigen/Core>
#include <array>
#include <tuple>
#include <vector>

namespace ecorche::tissue {

/// What is spread from a tissue's rows to get the tensor of its medium everywhere [ABLSJ21 §3.7]:
/// entries xx yy zz xy xz yz of its logarithm there, and 1.
using TensorEntries = std::array<double, 7>;
inline constexpr int kTensorEntries = std::tuple_size_v<TensorEntries>;

/// One for every sample, whose tissue's they are; curves turn to the skin of the domain.
/// @param samples  of this tissue alone, by curve, parameters ascending
[[nodiscard]] std::vector<TensorEntries> tensorEntries(const domain::Domain& domain,
                                                       const CurveTissue& tissue,
                                                       const std::vector<CoreSample>& samples);

/// The tensor at a place from what has been spread there: exp S, S = (Σ g S_j) / (Σ g).
class SpreadTensor {
 public:
  /// @param negligible  Σ g of less: behind other curves, out of reach; any tensor will do
  SpreadTensor(const Anisotropy& anisotropy, double negligible);
  /// @param spread  as TensorEntries
  [[nodiscard]] Eigen::Matrix3d operator()(const TensorEntries& spread) const;

 private:
  double lowest_ = 0.0;
  double highest_ = 0.0;
  double negligible_ = 0.0;
};

/// Tensor of every tet from what has been spread: the mean of those at its corners, of which fixed
/// ones have none.
/// @param spread  #rows×7, as TensorEntries
[[nodiscard]] std::vector<Eigen::Matrix3d> tetTensors(
    const mesh::TetMesh& mesh, const mesh::StiffnessPattern& pattern,
    const Eigen::Ref<const Eigen::MatrixXd>& spread, const Anisotropy& anisotropy);

/// Weight of a row in such a medium: a line has √det(A across it) times the capacity; the tissue's
/// own curve: √(λ2 λ3).
/// @param A  where the sample is
[[nodiscard]] double weightIn(const Eigen::Matrix3d& A, const CoreSample& sample);

}  // namespace ecorche::tissue
