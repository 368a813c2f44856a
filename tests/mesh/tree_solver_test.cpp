#include <ecorche/mesh/tree_solver.h>

#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "support/generated_domain.h"

using namespace ecorche;
using namespace ecorche::mesh;

namespace {

// The Laplacian of a box whose floor is fixed, and right sides that touch a few rows each.
struct Problem {
  StiffnessPattern pattern;
  std::shared_ptr<const Cholesky> factor;
  SparseColumns columns;
  Eigen::MatrixXd right;  // the same, full

  // A grid that nobody moved has no obtuse angles: the maximum principle holds exactly
  Problem(int cells, double jitter, std::uint64_t seed) {
    test::Grid grid;
    grid.cells = {cells, cells + 1, cells - 1};
    grid.jitter = jitter;
    grid.seed = seed;
    const TetMesh mesh = test::kuhnGrid(grid);
    std::vector<std::uint8_t> fixed(std::size_t(mesh.V.rows()), 0);
    for (Eigen::Index v = 0; v < mesh.V.rows(); ++v) fixed[std::size_t(v)] = mesh.V(v, 2) == 0.0;
    pattern = stiffnessPattern(mesh, fixed);
    factor = std::make_shared<const Cholesky>(
        SymbolicCholesky(pattern), assembleStiffness(mesh, pattern, edgeStiffness(mesh)));
    REQUIRE(factor->ok());
    std::mt19937_64 random(seed);
    right = Eigen::MatrixXd::Zero(pattern.rowCount(), 7);
    for (Eigen::Index c = 0; c < right.cols(); ++c) {
      for (int k = 0; k < 4; ++k) {
        const auto r = std::int32_t(random() % std::uint64_t(pattern.rowCount()));
        const double v = std::uniform_real_distribution<double>(-1.0, 1.0)(random);
        columns.add(r, v);
        right(r, c) += v;
      }
      columns.endColumn();
    }
  }
  [[nodiscard]] Eigen::MatrixXd solved(Eigen::MatrixXd b) const {
    factor->solveInPlace(b);
    return b;
  }
};

template <class Scalar>
Eigen::MatrixXd full(const typename TreeSolver<Scalar>::Answer& answer, Eigen::Index rows) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(rows, answer.value.cols());
  for (std::size_t i = 0; i < answer.row.size(); ++i)
    out.row(answer.row[i]) = answer.value.row(Eigen::Index(i)).template cast<double>();
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("sparse right sides are solved for as full ones are", "", float, double) {
  using Solver = TreeSolver<TestType>;
  const double eps = std::is_same_v<TestType, float> ? 1e-4 : 1e-11;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Problem problem(9, 0.2, seed);
    const Solver tree(problem.factor);
    const auto path = tree.pathOf(problem.columns.row);
    CHECK(path.rowCount() < problem.pattern.rowCount());
    const auto Z = tree.forward(path, problem.columns);
    const auto answer = tree.backward(path, Z, 0.0);
    CHECK(std::ssize(answer.row) == problem.pattern.rowCount());
    CHECK(std::set(answer.row.begin(), answer.row.end()).size() == answer.row.size());
    const Eigen::MatrixXd X = problem.solved(problem.right);
    const double scale = X.cwiseAbs().maxCoeff();
    CHECK((full<TestType>(answer, X.rows()) - X).cwiseAbs().maxCoeff() < eps * scale);
    // Bᵀ K⁻¹ B needs the way down alone
    CHECK((tree.product(path, Z, path, Z) - problem.right.transpose() * X).cwiseAbs().maxCoeff() <
          eps * scale);
  }
}

TEST_CASE("blocks on different paths multiply and add up as full ones do") {
  const Problem a(8, 0.2, 4);
  SparseColumns b;
  std::mt19937_64 random(5);
  for (int c = 0; c < 5; ++c) {
    b.add(std::int32_t(random() % std::uint64_t(a.pattern.rowCount())), 1.0);
    b.endColumn();
  }
  const TreeSolver<double> tree(a.factor);
  const auto pathA = tree.pathOf(a.columns.row);
  const auto pathB = tree.pathOf(b.row);
  const auto both = tree.join(pathA, pathB);
  const auto A = tree.forward(pathA, a.columns);
  const auto B = tree.forward(pathB, b);
  const Eigen::MatrixXd X = a.solved(a.right);
  Eigen::MatrixXd cross(b.count(), X.cols());
  for (Eigen::Index c = 0; c < b.count(); ++c) cross.row(c) = X.row(b.row[std::size_t(c)]);
  CHECK((tree.product(pathB, B, pathA, A) - cross).cwiseAbs().maxCoeff() < 1e-11);

  const Eigen::MatrixXd M = Eigen::MatrixXd::Random(A.cols(), 3);
  const Eigen::MatrixXd N = Eigen::MatrixXd::Random(B.cols(), 3);
  TreeSolver<double>::Block sum = TreeSolver<double>::Block::Zero(both.rowCount(), 3);
  tree.accumulate(pathA, A, M, both, sum);
  tree.accumulate(pathB, B, N, both, sum);
  Eigen::MatrixXd right = a.right * M;
  for (Eigen::Index c = 0; c < b.count(); ++c) right.row(b.row[std::size_t(c)]) += N.row(c);
  const Eigen::MatrixXd Y = a.solved(right);
  const auto answer = tree.backward(both, sum, 0.0);
  CHECK((full<double>(answer, Y.rows()) - Y).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE("what is left out is smaller than the tolerance, and what is not is right") {
  const Problem problem(14, 0.0, 6);
  const TreeSolver<double> tree(problem.factor);
  const auto path = tree.pathOf(problem.columns.row);
  const auto Z = tree.forward(path, problem.columns);
  const Eigen::MatrixXd X = problem.solved(problem.right);
  const double largest = X.cwiseAbs().maxCoeff();
  std::size_t before = std::size_t(X.rows());
  TreeSolver<double>::Workspace workspace;
  for (const double share : {0.0, 0.01, 0.1, 0.3}) {
    const double tolerance = share * largest;
    const auto answer = tree.backward(path, Z, tolerance, workspace);
    CHECK(answer.row.size() <= before);
    before = answer.row.size();
    const Eigen::MatrixXd Y = full<double>(answer, X.rows());
    double off = 0.0;
    double leftOut = 0.0;
    for (Eigen::Index i = 0; i < X.size(); ++i) {
      double& worst = Y.data()[i] == 0.0 ? leftOut : off;
      worst = std::max(worst, std::abs(Y.data()[i] - X.data()[i]));
    }
    CHECK(off < 1e-11);
    CHECK(leftOut <= tolerance + 1e-11);
  }
  CHECK(before < std::size_t(X.rows()) * 3 / 4);
}
