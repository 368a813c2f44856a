#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/anisotropy.h>
#include <ecorche/tissue/spread_tensors.h>

#include <algorithm>
#include <cmath>

namespace ecorche::tissue {

std::vector<TensorEntries> tensorEntries(const domain::Domain& domain, const CurveTissue& tissue,
                                         const std::vector<CoreSample>& samples) {
  EC_REQUIRE(std::ranges::is_sorted(samples, {}, &CoreSample::curve));
  std::vector<TensorEntries> out;
  out.reserve(samples.size());
  for (std::size_t c = 0; c < tissue.curves.size(); ++c) {
    std::vector<double> u;
    for (const CoreSample& s : samples) {
      if (s.curve == static_cast<std::int32_t>(c)) u.push_back(s.u);
    }
    for (const Frame& frame :
         curveFrames(domain, tissue.curves[c].spline, tissue.anisotropy.rotation, u)) {
      const Eigen::Matrix3d S = logTensor(frame, tissue.anisotropy);
      out.push_back({S(0, 0), S(1, 1), S(2, 2), S(0, 1), S(0, 2), S(1, 2), 1.0});
    }
  }
  return out;
}

std::vector<Eigen::Matrix3d> tetTensors(const mesh::TetMesh& mesh,
                                        const mesh::StiffnessPattern& pattern,
                                        const Eigen::Ref<const Eigen::MatrixXd>& spread,
                                        const Anisotropy& anisotropy) {
  const double l2 = std::log(anisotropy.lambda2);
  const double l3 = std::log(anisotropy.lambda3);
  const double lowest = std::min({0.0, l2, l3});
  const double highest = std::max({0.0, l2, l3});
  const double negligible = spread.rows() > 0 ? 1e-12 * spread.col(6).maxCoeff() : 0.0;
  std::vector<Eigen::Matrix3d> atRow(pattern.vertex.size());
  parallelFor(pattern.rowCount(), [&](std::int64_t r) {
    Eigen::Matrix3d& A = atRow[static_cast<std::size_t>(r)];
    A.setIdentity();
    const double total = spread(r, 6);
    if (!(total > negligible)) return;  // behind other curves, out of reach: any tensor will do
    Eigen::Matrix3d S;
    S << spread(r, 0), spread(r, 3), spread(r, 4),  //
        spread(r, 3), spread(r, 1), spread(r, 5),   //
        spread(r, 4), spread(r, 5), spread(r, 2);
    A = tensorFromLog(S / total, lowest, highest);
  });
  std::vector<Eigen::Matrix3d> A(static_cast<std::size_t>(mesh.T.rows()));
  parallelFor(mesh.T.rows(), [&](std::int64_t t) {
    // A mean of positive definite tensors is one; fixed corners have none of their own
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    int count = 0;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t r = pattern.row[static_cast<std::size_t>(mesh.T(t, k))];
      if (r < 0) continue;
      sum += atRow[static_cast<std::size_t>(r)];
      ++count;
    }
    A[static_cast<std::size_t>(t)] =
        count > 0 ? Eigen::Matrix3d(sum / count) : Eigen::Matrix3d::Identity();
  });
  return A;
}

double weightIn(const std::vector<Eigen::Matrix3d>& A, const CoreSample& sample) {
  return sample.weight * crossCapacity(A[static_cast<std::size_t>(sample.tet)], sample.tangent);
}

}  // namespace ecorche::tissue
