#include <ecorche/core/parallel.h>
#include <ecorche/mesh/cholesky.h>
#include <ecorche/mesh/operators.h>
#include <ecorche/mesh/tet_locator.h>

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <random>

#include "support/generated_domain.h"

using namespace ecorche;
using namespace ecorche::mesh;

namespace {

TetMesh jitteredBox(int cells, std::uint64_t seed) {
  test::Grid grid;
  grid.cells = {cells, cells, cells};
  grid.jitter = 0.2;
  grid.seed = seed;
  return test::kuhnGrid(grid);
}

Eigen::MatrixXd dense(const StiffnessPattern& pattern, const std::vector<double>& values) {
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(pattern.rowCount(), pattern.rowCount());
  for (std::int32_t c = 0; c < pattern.rowCount(); ++c) {
    for (auto i = pattern.first[std::size_t(c)]; i < pattern.first[std::size_t(c) + 1]; ++i) {
      const auto r = pattern.index[std::size_t(i)];
      K(r, c) = K(c, r) = values[std::size_t(i)];
    }
  }
  return K;
}

}  // namespace

TEST_CASE("the gradient of a linear function is its slope in every tet") {
  const TetMesh mesh = jitteredBox(4, 3);
  const Vector3 slope(0.3, -1.2, 2.0);
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    Eigen::Vector4d f;
    for (int k = 0; k < 4; ++k) f[k] = mesh.V.row(mesh.T(t, k)).dot(slope);
    REQUIRE((barycentricGradients(mesh, t).transpose() * f - slope).norm() < 1e-12);
  }
}

TEST_CASE("barycentric coordinates add up to one and give the point back") {
  const TetMesh mesh = jitteredBox(3, 5);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> unit(-0.5, 1.5);
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    const Vector3 p(unit(random), unit(random), unit(random));
    const Eigen::Vector4d b = barycentric(mesh, t, p);
    Vector3 back = Vector3::Zero();
    for (int k = 0; k < 4; ++k) back += b[k] * mesh.V.row(mesh.T(t, k)).transpose();
    REQUIRE(b.sum() == Approx(1.0));
    REQUIRE((back - p).norm() < 1e-9);
  }
}

TEST_CASE(
    "the stiffness of a linear function is its energy, for any tensor, and constants have none") {
  const TetMesh mesh = jitteredBox(5, 7);
  const std::vector<std::uint8_t> none(std::size_t(mesh.V.rows()), 0);
  const StiffnessPattern pattern = stiffnessPattern(mesh, none);
  Eigen::Matrix3d A;
  A << 2.0, 0.3, 0.1, 0.3, 1.0, -0.2, 0.1, -0.2, 0.5;
  const std::vector<Eigen::Matrix3d> tensors(std::size_t(mesh.T.rows()), A);
  const Vector3 slope(1.0, 2.0, -0.5);
  const Eigen::VectorXd f = mesh.V * slope;
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(mesh.V.rows());

  const Eigen::MatrixXd K = dense(pattern, assembleStiffness(mesh, pattern, edgeStiffness(mesh)));
  const Eigen::MatrixXd KA =
      dense(pattern, assembleStiffness(mesh, pattern, edgeStiffness(mesh, tensors)));
  CHECK(f.dot(K * f) == Approx(slope.squaredNorm()));  // the box has volume 1
  CHECK(f.dot(KA * f) == Approx(slope.dot(A * slope)));
  CHECK((K * one).cwiseAbs().maxCoeff() < 1e-12);
  CHECK((KA * one).cwiseAbs().maxCoeff() < 1e-12);
  CHECK(lumpedMass(mesh).sum() == Approx(1.0));
}

TEST_CASE("fixed vertices have no row, and the rest of the matrix is what it was") {
  const TetMesh mesh = jitteredBox(4, 9);
  std::vector<std::uint8_t> fixed(std::size_t(mesh.V.rows()), 0);
  for (std::size_t v = 0; v < fixed.size(); v += 3) fixed[v] = 1;
  const StiffnessPattern all = stiffnessPattern(mesh, std::vector<std::uint8_t>(fixed.size(), 0));
  const StiffnessPattern some = stiffnessPattern(mesh, fixed);
  const EdgeStiffness stiffness = edgeStiffness(mesh);
  const Eigen::MatrixXd whole = dense(all, assembleStiffness(mesh, all, stiffness));
  const Eigen::MatrixXd part = dense(some, assembleStiffness(mesh, some, stiffness));
  double worst = 0.0;
  for (std::int32_t i = 0; i < some.rowCount(); ++i) {
    for (std::int32_t j = 0; j < some.rowCount(); ++j) {
      worst = std::max(worst, std::abs(part(i, j) - whole(some.vertex[std::size_t(i)],
                                                          some.vertex[std::size_t(j)])));
    }
  }
  CHECK(worst < 1e-14);
}

TEST_CASE("a flat tet's energy is capped and stays positive semidefinite") {
  TetMesh mesh;
  mesh.V.resize(4, 3);
  mesh.V << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 1e-12;
  mesh.T.resize(1, 4);
  mesh.T << 0, 1, 2, 3;
  const EdgeStiffness stiffness = edgeStiffness(mesh);
  REQUIRE(stiffness.flattened == std::vector<std::int32_t>{0});
  const StiffnessPattern pattern = stiffnessPattern(mesh, std::vector<std::uint8_t>(4, 0));
  const Eigen::MatrixXd K = dense(pattern, assembleStiffness(mesh, pattern, stiffness));
  const Eigen::VectorXd lambda = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
  CHECK(lambda[0] > -1e-9 * lambda[3]);
  CHECK(lambda[3] < 1e7);
}

TEST_CASE("Cholesky solves, blocks do not depend on threads, and a bad pivot is named") {
  const TetMesh mesh = jitteredBox(8, 11);
  std::vector<std::uint8_t> fixed(std::size_t(mesh.V.rows()), 0);
  for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) fixed[std::size_t(v)] = mesh.V(v, 2) == 0.0;
  const StiffnessPattern pattern = stiffnessPattern(mesh, fixed);
  std::vector<double> values = assembleStiffness(mesh, pattern, edgeStiffness(mesh));
  const Eigen::MatrixXd K = dense(pattern, values);
  const SymbolicCholesky symbolic(pattern);
  const Cholesky factor(symbolic, values);
  REQUIRE(factor.ok());
  const Eigen::MatrixXd truth = Eigen::MatrixXd::Random(pattern.rowCount(), 19);
  Eigen::MatrixXd X = K * truth;
  factor.solveInPlace(X);
  CHECK((X - truth).cwiseAbs().maxCoeff() < 1e-10);

  Eigen::MatrixXd again = K * truth;
  {
    const ThreadLimit one(1);
    factor.solveInPlace(again);
  }
  CHECK(again == X);

  const std::int32_t culprit = pattern.rowCount() / 2;
  values[std::size_t(pattern.diagonal(culprit))] = -1.0;
  const Cholesky broken(symbolic, values);
  REQUIRE_FALSE(broken.ok());
  CHECK(broken.badRow() >= 0);
  CHECK(broken.badRow() < pattern.rowCount());
}

TEST_CASE("the field between two spheres converges to its closed form") {
  // f = 1 on the inner sphere, 0 on the outer one: f = (1/r − 1/R) / (1/r0 − 1/R)
  const double r0 = 0.4;
  double before = 1.0;
  for (const int fineness : {6, 12, 24}) {
    const domain::Domain shell = test::shellDomain(r0, 1.0, fineness);
    std::vector<std::uint8_t> fixed(std::size_t(shell.mesh.V.rows()), 0);
    Eigen::VectorXd exact(shell.mesh.V.rows());
    for (Eigen::Index v = 0; v < shell.mesh.V.rows(); ++v) {
      const double r = shell.mesh.V.row(v).norm();
      fixed[std::size_t(v)] = r > 1.0 - 1e-9 || r < r0 + 1e-9;
      exact[v] = (1.0 / r - 1.0) / (1.0 / r0 - 1.0);
    }
    const StiffnessPattern pattern = stiffnessPattern(shell.mesh, fixed);
    const EdgeStiffness stiffness = edgeStiffness(shell.mesh);
    const Cholesky factor(SymbolicCholesky(pattern),
                          assembleStiffness(shell.mesh, pattern, stiffness));
    REQUIRE(factor.ok());
    Eigen::MatrixXd f = Eigen::MatrixXd::Zero(pattern.rowCount(), 1);
    for (Eigen::Index t = 0; t < shell.mesh.T.rows(); ++t) {
      for (std::size_t e = 0; e < 6; ++e) {
        for (int side = 0; side < 2; ++side) {
          const auto v = shell.mesh.T(t, kTetEdge[e][side]);
          const auto w = shell.mesh.T(t, kTetEdge[e][1 - side]);
          const auto r = pattern.row[std::size_t(v)];
          if (r >= 0 && fixed[std::size_t(w)] != 0)
            f(r, 0) -= stiffness.k[std::size_t(t)][e] * exact[w];
        }
      }
    }
    factor.solveInPlace(f);
    double error = 0.0;
    for (std::int32_t r = 0; r < pattern.rowCount(); ++r) {
      error = std::max(error, std::abs(f(r, 0) - exact[pattern.vertex[std::size_t(r)]]));
    }
    CHECK(error < 0.4 * before);
    before = error;
  }
  CHECK(before < 2e-3);
}

TEST_CASE("the locator finds the tet of every centroid and nothing outside") {
  const TetMesh mesh = jitteredBox(6, 13);
  const TetLocator locator(mesh);
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    const Vector3 c = mesh.V(mesh.T.row(t), Eigen::all).colwise().mean().transpose();
    REQUIRE(locator.locate(c) == t);
  }
  CHECK(locator.locate({1.01, 0.5, 0.5}) == -1);
  CHECK(locator.locate({0.5, -3.0, 0.5}) == -1);
  CHECK(locator.locate({0.0, 0.0, 0.0}) >= 0);  // a corner of the box counts as inside
}
