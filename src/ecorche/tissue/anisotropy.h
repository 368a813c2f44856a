#pragma once

#include <ecorche/domain/domain.h>
#include <ecorche/tissue/tissue.h>

#include <Eigen/Core>
#include <vector>

namespace ecorche::tissue {

/// Right-handed orthonormal frame of a curve as columns: e1 the tangent, e2 and e3 across it.
using Frame = Eigen::Matrix3d;

/// Frames at the given parameters (ascending), carried along by parallel transport [Hanson & Ma
/// 1995].
///
/// Where the rotation is 0, e3 at the middle of the curve points to the skin around it, so that λ3
/// is the spread towards the skin and λ2 the spread along it. The frames turn with the model.
[[nodiscard]] std::vector<Frame> curveFrames(const domain::Domain& domain,
                                             const mesh::Spline& spline, double rotation,
                                             const std::vector<double>& parameters);

/// log(Q Λ Qᵀ) with Λ = diag(1, λ2, λ3). Departure from [ABLSJ21 §3.7], which prints QᵀΛQ for frame
/// vectors as columns.
[[nodiscard]] Eigen::Matrix3d logTensor(const Frame& frame, const Anisotropy& anisotropy);

/// exp of a symmetric matrix whose eigenvalues are first brought into [lowest, highest]: positive
/// definite whatever comes.
[[nodiscard]] Eigen::Matrix3d tensorFromLog(const Eigen::Matrix3d& log, double lowest,
                                            double highest);

/// √det of the tensor across a direction: what the capacity of a line along `tangent` is multiplied
/// with.
[[nodiscard]] double crossCapacity(const Eigen::Matrix3d& tensor, const mesh::Vector3& tangent);

}  // namespace ecorche::tissue
