#include <ecorche/tissue/anisotropy.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/tissue_solver.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "support/generated_domain.h"
#include "tissue/curves.h"

using namespace ecorche;
using namespace ecorche::tissue;
using mesh::Vector3;
using test::muscle;

TEST_CASE("frames stay orthonormal and right-handed, and twist no more than the curve makes them") {
  const domain::Domain domain = test::cylinderDomain(1.0, 4.0, 8, 1);
  const mesh::Spline spline({{0.1, 0.3, 0.2}, {-0.4, 0.2, 1.0}, {0.3, -0.5, 2.2}, {0.2, 0.4, 3.6}});
  std::vector<double> u;
  for (int k = 0; k <= 300; ++k) u.push_back(spline.lastParameter() * k / 300);
  const auto frames = curveFrames(domain, spline, 0.7, u);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    REQUIRE((frames[k].transpose() * frames[k] - Eigen::Matrix3d::Identity()).norm() < 1e-12);
    REQUIRE(frames[k].determinant() == Approx(1.0));
    REQUIRE((frames[k].col(0) - spline.tangent(u[k])).norm() < 1e-12);
    if (k == 0) continue;
    // Parallel transport: the change of e2 has no part along e3
    const Vector3 change = frames[k].col(1) - frames[k - 1].col(1);
    REQUIRE(std::abs(change.dot(frames[k].col(2))) < 1e-3 * 0.1 + 0.02 * change.norm());
  }
}

TEST_CASE("frames of a plane curve stay in its plane, wherever the samples are") {
  const domain::Domain domain = test::cylinderDomain(1.0, 4.0, 8, 1);
  const mesh::Spline spline({{0.0, -0.5, 0.5}, {0.0, 0.3, 1.5}, {0.0, 0.4, 2.5}, {0.0, -0.4, 3.5}});
  for (const auto& u :
       {std::vector<double>{0.1, 2.9}, std::vector<double>{0.1, 0.5, 1.0, 2.0, 2.9}}) {
    const auto frames = curveFrames(domain, spline, 0.0, u);
    const double first = frames.front().col(1).x();
    for (const Frame& f : frames) CHECK(f.col(1).x() == Approx(first).margin(1e-9));
  }
}

TEST_CASE("at rest e3 points to the near skin") {
  const domain::Domain domain = test::cylinderDomain(1.0, 4.0, 12, 0);
  const auto frames =
      curveFrames(domain, mesh::Spline({{0.6, 0.0, 0.5}, {0.6, 0.0, 3.5}}), 0.0, {0.2, 0.8});
  CHECK(std::abs(frames[0].col(2).x()) > 0.99);
  const auto turned = curveFrames(domain, mesh::Spline({{0.6, 0.0, 0.5}, {0.6, 0.0, 3.5}}),
                                  0.5 * std::numbers::pi, {0.2, 0.8});
  CHECK(std::abs(turned[0].col(1).x()) > 0.99);
}

TEST_CASE("tensors from any logarithm are symmetric and positive definite within their bounds") {
  std::mt19937_64 random(8);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 1000; ++round) {
    Eigen::Matrix3d S;
    for (int i = 0; i < 9; ++i) S(i) = 3.0 * normal(random);
    S = Eigen::Matrix3d(S + S.transpose());
    const Eigen::Matrix3d A = tensorFromLog(S, -1.0, 0.5);
    REQUIRE((A - A.transpose()).norm() < 1e-12);
    const Eigen::Vector3d lambda = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(A).eigenvalues();
    REQUIRE(lambda[0] > std::exp(-1.0) * (1.0 - 1e-9));
    REQUIRE(lambda[2] < std::exp(0.5) * (1.0 + 1e-9));
  }
}

TEST_CASE("a frame's tensor is Q diag(1, λ2, λ3) Qᵀ and its cross capacity √(λ2 λ3)") {
  const Frame Q(Eigen::AngleAxisd(0.8, Vector3(1, 2, -1).normalized()).toRotationMatrix());
  const Anisotropy a{0.5, 0.1, 0.0};
  const Eigen::Matrix3d A = tensorFromLog(logTensor(Q, a), std::log(0.1), 0.0);
  const Eigen::Matrix3d expected = Q * Vector3(1.0, 0.5, 0.1).asDiagonal() * Q.transpose();
  CHECK((A - expected).norm() < 1e-12);
  CHECK(crossCapacity(A, Q.col(0)) == Approx(std::sqrt(0.05)));
  CHECK(crossCapacity(Eigen::Matrix3d::Identity(), Q.col(1)) == Approx(1.0));
}

TEST_CASE("a muscle that spreads little towards the skin is flat") {
  // In stretched coordinates the muscle is round, so it is √λ3 times as thick as wide where walls
  // are far
  const domain::Domain domain = test::cylinderDomain(1.0, 1.0, 24, 2);
  CurveTissue m = muscle("m", {{0.2, 0.0, -0.01}, {0.2, 0.0, 1.01}}, 3.0);
  m.anisotropy = {1.0, 0.25, 0.0};
  TissueOptions options;
  options.coreRadius = 0.02;
  options.fat = 1.0;
  RunContext run;
  const auto cores = traceCurves(domain, {m}, options, run);
  REQUIRE(cores.has_value());
  const auto fields = solveTissueFields(domain, *cores, {m}, options, run);
  REQUIRE(fields.has_value());
  Eigen::Array2d extent(0.0, 0.0);
  const auto owner = vertexOwners(*fields);
  for (Eigen::Index v = 0; v < domain.mesh.V.rows(); ++v) {
    if (owner[std::size_t(v)] != kFirstMuscle) continue;
    extent = extent.max(
        Eigen::Array2d(std::abs(domain.mesh.V(v, 0) - 0.2), std::abs(domain.mesh.V(v, 1))));
  }
  INFO(extent.transpose());
  CHECK(extent[0] < 0.75 * extent[1]);
  CHECK(fields->undershoot < 0.02);
  CHECK(fields->overshoot < 0.02);
}

TEST_CASE("equal spread in all directions is the isotropic field, whatever way it is computed") {
  const domain::Domain domain = test::cylinderDomain(1.0, 1.5, 14, 3);
  CurveTissue a = muscle("a", {{0.3, 0.1, 0.2}, {0.1, 0.0, 0.8}, {0.3, -0.2, 1.3}});
  const CurveTissue b = muscle("b", {{-0.3, 0.1, 0.2}, {-0.3, -0.2, 1.3}});
  TissueOptions options;
  RunContext run;
  const auto cores = traceCurves(domain, {a, b}, options, run);
  REQUIRE(cores.has_value());
  const auto isotropic = solveTissueFields(domain, *cores, {a, b}, options, run);
  a.anisotropy.lambda2 = 1.0 + 1e-12;
  const auto general = solveTissueFields(domain, *cores, {a, b}, options, run);
  REQUIRE(isotropic.has_value());
  REQUIRE(general.has_value());
  CHECK((isotropic->values - general->values).cwiseAbs().maxCoeff() < 1e-9);
}
