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

SpreadTensor::SpreadTensor(const Anisotropy& anisotropy, double negligible)
    : negligible_(negligible) {
  const double l2 = std::log(anisotropy.lambda2);
  const double l3 = std::log(anisotropy.lambda3);
  lowest_ = std::min({0.0, l2, l3});
  highest_ = std::max({0.0, l2, l3});
}

Eigen::Matrix3d SpreadTensor::operator()(const TensorEntries& spread) const {
  const double total = spread[6];
  if (!(total > negligible_)) return Eigen::Matrix3d::Identity();
  Eigen::Matrix3d S;
  S << spread[0], spread[3], spread[4],  //
      spread[3], spread[1], spread[5],   //
      spread[4], spread[5], spread[2];
  return tensorFromLog(S / total, lowest_, highest_);
}

std::vector<Eigen::Matrix3d> tetTensors(const mesh::TetMesh& mesh,
                                        const mesh::StiffnessPattern& pattern,
                                        const Eigen::Ref<const Eigen::MatrixXd>& spread,
                                        const Anisotropy& anisotropy) {
  const SpreadTensor tensor(anisotropy, spread.rows() > 0 ? 1e-12 * spread.col(6).maxCoeff() : 0.0);
  std::vector<Eigen::Matrix3d> atRow(pattern.vertex.size());
  parallelFor(pattern.rowCount(), [&](std::int64_t r) {
    TensorEntries here{};
    for (std::size_t k = 0; k < here.size(); ++k) here[k] = spread(r, static_cast<Eigen::Index>(k));
    atRow[static_cast<std::size_t>(r)] = tensor(here);
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

double weightIn(const Eigen::Matrix3d& A, const CoreSample& sample) {
  return sample.weight * crossCapacity(A, sample.tangent);
}

}  // namespace ecorche::tissue
