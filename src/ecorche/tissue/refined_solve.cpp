#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/refined_solve.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace ecorche::tissue {

namespace {

// Shares of a column's scale. Done once a pass changes nothing by more: the next would change less
// by another four digits.
constexpr double kDone = 1e-7;
// Corrections below are not followed: after the last pass there is none left above kDone²
constexpr double kNothing = 1e-11;
// Residuals below, over the diagonal, are rounding in 64 bits
constexpr double kRounding = 1e-14;
constexpr int kMostPasses = 8;
constexpr std::int64_t kGrain = 2048;

using Tree = mesh::TreeSolver<float>;

// Entries of b − K X that are more than rounding.
mesh::SparseColumns residual(const DragGround& ground, const FieldMatrix& b,
                             const Eigen::Ref<const Eigen::VectorXd>& scale, const FieldMatrix& X) {
  const mesh::StiffnessPattern& pattern = ground.solver->pattern();
  const mesh::NeighbourRows& rows = *ground.rows;
  const std::vector<double>& K = ground.K;
  const Eigen::Index n = X.rows();
  const Eigen::Index k = X.cols();
  struct Entry {
    std::int32_t row;
    double value;
  };
  const Eigen::Index chunks = (n + kGrain - 1) / kGrain;
  std::vector<std::vector<std::vector<Entry>>> found(static_cast<std::size_t>(chunks));
  parallelFor(
      chunks,
      [&](std::int64_t chunk) {
        auto& own = found[static_cast<std::size_t>(chunk)];
        own.resize(static_cast<std::size_t>(k));
        Eigen::RowVectorXd r(k);
        for (Eigen::Index i = chunk * kGrain; i < std::min(n, (chunk + 1) * kGrain); ++i) {
          const auto row = static_cast<std::int32_t>(i);
          const double diagonal = K[static_cast<std::size_t>(pattern.diagonal(row))];
          r = b.row(i) - diagonal * X.row(i);
          for (auto e = static_cast<std::size_t>(rows.first[static_cast<std::size_t>(i)]);
               e < static_cast<std::size_t>(rows.first[static_cast<std::size_t>(i) + 1]); ++e)
            r -= K[static_cast<std::size_t>(rows.slot[e])] * X.row(rows.neighbour[e]);
          for (Eigen::Index c = 0; c < k; ++c) {
            if (std::abs(r[c]) > kRounding * diagonal * scale[c])
              own[static_cast<std::size_t>(c)].push_back({row, r[c]});
          }
        }
      },
      1);
  mesh::SparseColumns out;
  for (Eigen::Index c = 0; c < k; ++c) {
    for (const auto& chunk : found) {
      for (const Entry& entry : chunk[static_cast<std::size_t>(c)]) out.add(entry.row, entry.value);
    }
    out.endColumn();
  }
  return out;
}

}  // namespace

Refined refinedSolve(const DragGround& ground, const FieldMatrix& b,
                     const Eigen::Ref<const Eigen::VectorXd>& scale, FieldMatrix& X,
                     const std::function<bool()>& stop) {
  EC_REQUIRE(b.rows() == X.rows() && b.cols() == X.cols() && scale.size() == X.cols());
  Refined out;
  const Tree& tree = ground.tree;
  std::array<Tree::Workspace, 2> workspace;
  double before = std::numeric_limits<double>::infinity();
  double visited = 0.0;
  const auto half = static_cast<Eigen::Index>(X.cols() + 1) / 2;
  const double tolerance = X.cols() > 0 ? kNothing * scale.minCoeff() : 0.0;
  for (; out.passes < kMostPasses;) {
    if (stop && stop()) return out;
    const mesh::SparseColumns left = residual(ground, b, scale, X);
    if (left.row.empty()) {
      out.done = true;
      break;
    }
    if (stop && stop()) return out;
    const Tree::Path path = tree.pathOf(left.row);
    const Tree::Block Z = tree.forward(path, left);
    if (stop && stop()) return out;
    std::array<double, 2> step{};
    std::array<std::size_t, 2> rows{};
    parallelFor(
        2,
        [&](std::int64_t i) {
          const auto k = static_cast<std::size_t>(i);
          const Eigen::Index begin = i == 0 ? 0 : half;
          const Eigen::Index count = i == 0 ? half : X.cols() - half;
          if (count == 0) return;
          const Tree::Answer answer =
              tree.backward(path, Z.middleCols(begin, count), tolerance, workspace[k]);
          rows[k] = answer.row.size();
          Eigen::RowVectorXd largest = Eigen::RowVectorXd::Zero(count);
          for (std::size_t a = 0; a < answer.row.size(); ++a) {
            const Eigen::RowVectorXd change =
                answer.value.row(static_cast<Eigen::Index>(a)).cast<double>();
            X.row(answer.row[a]).segment(begin, count) += change;
            largest = largest.cwiseMax(change.cwiseAbs());
          }
          step[k] = (largest.array() / scale.segment(begin, count).transpose().array()).maxCoeff();
        },
        1);
    ++out.passes;
    out.lastStep = std::max(step[0], step[1]);
    visited += static_cast<double>(rows[0] + rows[1]) / 2.0 / static_cast<double>(X.rows());
    // A step that is not far smaller than the one before it will not end at all
    if (!(out.lastStep < 0.1 * before)) break;
    before = out.lastStep;
    if (out.lastStep < kDone) {
      out.done = true;
      break;
    }
  }
  if (out.passes > 0) out.visitedShare = visited / out.passes;
  return out;
}

}  // namespace ecorche::tissue
