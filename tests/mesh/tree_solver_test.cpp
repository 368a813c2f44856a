#include <ecorche/core/parallel.h>
#include <ecorche/mesh/single_cholesky.h>
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
  std::vector<double> values;
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
    values = assembleStiffness(mesh, pattern, edgeStiffness(mesh));
    factor = std::make_shared<const Cholesky>(SymbolicCholesky(pattern), values);
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

TEST_CASE("a factor in 32 bits solves as one in 64 does, as far as they go") {
  // From panels that one thread factors to such as all do
  const int cells = GENERATE(3, 9, 16);
  const Problem problem(cells, 0.2, 7);
  const SymbolicCholesky symbolic(problem.pattern);
  const auto factor = std::make_shared<const SingleCholesky>(symbolic, problem.values);
  REQUIRE(factor->ok());
  CHECK(factor->shareMade() == 1.0);
  const TreeSolver<float> tree(factor);
  const auto path = tree.pathOf(problem.columns.row);
  const Eigen::MatrixXd X = problem.solved(problem.right);
  const Eigen::MatrixXd Y =
      full<float>(tree.backward(path, tree.forward(path, problem.columns), 0.0), X.rows());
  CHECK((Y - X).cwiseAbs().maxCoeff() < 2e-5 * X.cwiseAbs().maxCoeff());
}

TEST_CASE("where few rows change, a factor made of another is the same to the last bit") {
  const Problem problem(14, 0.2, 8);
  const SymbolicCholesky symbolic(problem.pattern);
  const auto before = std::make_shared<const SingleCholesky>(symbolic, problem.values);
  std::vector<std::int32_t> changed;
  auto values = problem.values;
  std::mt19937_64 random(9);
  for (int k = 0; k < 5; ++k) {
    changed.push_back(std::int32_t(random() % std::uint64_t(problem.pattern.rowCount())));
    values[std::size_t(problem.pattern.diagonal(changed.back()))] *= 1.5;
  }
  const auto all = std::make_shared<const SingleCholesky>(symbolic, values);
  const auto some = std::make_shared<const SingleCholesky>(before, values, changed);
  REQUIRE(all->ok());
  REQUIRE(some->ok());
  CHECK(some->shareMade() < 1.0);
  const TreeSolver<float> a(all);
  const TreeSolver<float> b(some);
  const auto path = a.pathOf(problem.columns.row);
  const auto A = a.backward(path, a.forward(path, problem.columns), 0.0);
  const auto B = b.backward(path, b.forward(path, problem.columns), 0.0);
  CHECK(A.value == B.value);
  // And of that one again, back to where it was
  const auto back = std::make_shared<const SingleCholesky>(some, problem.values, changed);
  const TreeSolver<float> c(back);
  const TreeSolver<float> d(before);
  CHECK(c.backward(path, c.forward(path, problem.columns), 0.0).value ==
        d.backward(path, d.forward(path, problem.columns), 0.0).value);
}

TEST_CASE("a factor in 32 bits has the same bytes on any number of threads") {
  const Problem problem(16, 0.2, 10);
  const SymbolicCholesky symbolic(problem.pattern);
  const auto answer = [&](int threads) {
    const ThreadLimit limit(threads);
    const TreeSolver<float> tree(std::make_shared<const SingleCholesky>(symbolic, problem.values));
    const auto path = tree.pathOf(problem.columns.row);
    return tree.backward(path, tree.forward(path, problem.columns), 0.0).value;
  };
  CHECK(answer(1) == answer(2));
}

TEST_CASE("what is not positive definite, or stopped, is no factor") {
  const Problem problem(9, 0.2, 11);
  const SymbolicCholesky symbolic(problem.pattern);
  CHECK_FALSE(SingleCholesky(symbolic, problem.values, [] { return true; }).ok());
  auto values = problem.values;
  values[std::size_t(problem.pattern.diagonal(problem.pattern.rowCount() / 2))] = -1.0;
  CHECK_FALSE(SingleCholesky(symbolic, values).ok());
}
