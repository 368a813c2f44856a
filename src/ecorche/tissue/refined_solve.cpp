#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/refined_solve.h>

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

namespace ecorche::tissue {

namespace {

// Shares of a column's scale.
// What the pass after the last one would change by: done.
constexpr double kDone = 1e-8;
// From nothing, passes go on to here: stubborn rows are found once, for all solves that follow.
constexpr double kLearned = 1e-10;
// Corrections below are not followed; a sliver's rows may make a hundred times as much of them, and
// turn out stubborn then
constexpr double kNoCorrection = 3e-10;
// Residuals below are left; over the diagonal, or over most rows' where that is less: rows that
// hold on to each other feel a residual far more than their diagonals say
constexpr double kRounding = 3e-14;
constexpr int kMostPasses = 10;
// Columns that the first pass changes by less than corrections that are followed are not looked at
// again, where they are so many that it pays
constexpr double kMostColumns = 0.75;
// A pass that leaves more than this of the one before meets rows that 32 bits cannot tell apart;
// they are those that changed by more than kStubborn of the most, and two rings around them
constexpr double kSlow = 0.01;
constexpr double kStubborn = 0.03;
constexpr double kHopeless = 1e-5;
constexpr std::size_t kMostStubborn = 20'000;
constexpr std::int64_t kResidualGrain = 2048;

using Tree = mesh::TreeSolver<float>;

// One row of b − K X.
void residualOf(const DragGround& ground, const SparseSides& b, const FieldMatrix& X,
                std::int32_t row, double* r) {
  const mesh::NeighbourRows& rows = *ground.rows;
  const auto i = static_cast<std::size_t>(row);
  const Eigen::Index k = X.cols();
  const double diagonal = ground.diagonal(row);
  const double* x = X.data() + row * k;
  for (Eigen::Index c = 0; c < k; ++c) r[c] = -diagonal * x[c];
  if (b.place[i] >= 0) {
    const double* right = b.value.data() + b.place[i] * k;
    for (Eigen::Index c = 0; c < k; ++c) r[c] += right[c];
  }
  for (auto e = static_cast<std::size_t>(rows.first[i]);
       e < static_cast<std::size_t>(rows.first[i + 1]); ++e) {
    const double entry = ground.K[static_cast<std::size_t>(rows.slot[e])];
    const double* other = X.data() + rows.neighbour[e] * k;
    for (Eigen::Index c = 0; c < k; ++c) r[c] -= entry * other[c];
  }
}

// Entries of b − K X that are more than nothing, in some rows. Rows come in the order of
// elimination, so that those in hand are neighbours.
mesh::SparseColumns residual(const DragGround& ground, const SparseSides& b,
                             const Eigen::Ref<const Eigen::VectorXd>& scale, const FieldMatrix& X,
                             std::span<const std::int32_t> rows, double usual) {
  const auto n = std::ssize(rows);
  const Eigen::Index k = X.cols();
  struct Entry {
    std::int32_t row;
    double value;
  };
  const Eigen::Index chunks = (n + kResidualGrain - 1) / kResidualGrain;
  std::vector<std::vector<std::vector<Entry>>> found(static_cast<std::size_t>(chunks));
  parallelFor(
      chunks,
      [&](std::int64_t chunk) {
        auto& own = found[static_cast<std::size_t>(chunk)];
        own.resize(static_cast<std::size_t>(k));
        Eigen::RowVectorXd r(k);
        for (auto i = chunk * kResidualGrain;
             i < std::min<std::int64_t>(n, (chunk + 1) * kResidualGrain); ++i) {
          const std::int32_t row = rows[static_cast<std::size_t>(i)];
          const double nothing = kRounding * std::min(usual, ground.diagonal(row));
          residualOf(ground, b, X, row, r.data());
          for (Eigen::Index c = 0; c < k; ++c) {
            if (std::abs(r[c]) > nothing * scale[c])
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

// The middle one of all diagonals.
double usualDiagonal(const DragGround& ground) {
  std::vector<double> diagonal;
  for (std::int32_t r = 0; r < ground.pattern->rowCount(); ++r)
    diagonal.push_back(ground.diagonal(r));
  const auto middle = diagonal.begin() + std::ssize(diagonal) / 2;
  std::ranges::nth_element(diagonal, middle);
  return *middle;
}

// Rows whose residual a change of these has changed.
std::vector<std::int32_t> withNeighbours(const DragGround& ground,
                                         std::span<const std::int32_t> some) {
  std::vector<std::uint8_t> is(ground.rows->first.size() - 1, 0);
  for (const std::int32_t row : some) {
    const auto r = static_cast<std::size_t>(row);
    is[r] = 1;
    for (auto e = static_cast<std::size_t>(ground.rows->first[r]);
         e < static_cast<std::size_t>(ground.rows->first[r + 1]); ++e)
      is[static_cast<std::size_t>(ground.rows->neighbour[e])] = 1;
  }
  std::vector<std::int32_t> out;
  for (const std::int32_t row : ground.symbolic->order()) {
    if (is[static_cast<std::size_t>(row)] != 0) out.push_back(row);
  }
  return out;
}

// Rows that 32 bits cannot tell apart, say the corners of a sliver: solved for among themselves
// in 64.
class Stubborn {
 public:
  Stubborn(const DragGround& ground, std::vector<std::int32_t> rows) : ground_(ground) {
    set(std::move(rows));
  }
  [[nodiscard]] const std::vector<std::int32_t>& rows() const { return rows_; }

  // With two rings around them; which it answers
  std::vector<std::int32_t> add(std::vector<std::int32_t> more) {
    for (int ring = 0; ring < 2; ++ring) {
      const std::size_t count = more.size();
      for (std::size_t i = 0; i < count; ++i) {
        const auto r = static_cast<std::size_t>(more[i]);
        more.insert(more.end(), ground_.rows->neighbour.begin() + ground_.rows->first[r],
                    ground_.rows->neighbour.begin() + ground_.rows->first[r + 1]);
      }
      std::ranges::sort(more);
      const auto same = std::ranges::unique(more);
      more.erase(same.begin(), same.end());
    }
    std::vector<std::int32_t> both;
    std::ranges::set_union(rows_, more, std::back_inserter(both));
    if (both.size() > kMostStubborn) return {};
    set(std::move(both));
    return more;
  }
  void solve(const SparseSides& b, FieldMatrix& X) const {
    if (rows_.empty() || !ok_) return;
    FieldMatrix left(std::ssize(rows_), X.cols());
    for (std::size_t i = 0; i < rows_.size(); ++i)
      residualOf(ground_, b, X, rows_[i], left.row(static_cast<Eigen::Index>(i)).data());
    const Eigen::MatrixXd step = factor_.solve(Eigen::MatrixXd(left));
    for (std::size_t i = 0; i < rows_.size(); ++i)
      X.row(rows_[i]) += step.row(static_cast<Eigen::Index>(i));
  }

 private:
  void set(std::vector<std::int32_t> rows) {
    rows_ = std::move(rows);
    if (rows_.empty()) return;
    std::vector<Eigen::Triplet<double>> entries;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const auto at = static_cast<int>(i);
      const auto r = static_cast<std::size_t>(rows_[i]);
      entries.emplace_back(at, at, ground_.diagonal(rows_[i]));
      for (auto e = static_cast<std::size_t>(ground_.rows->first[r]);
           e < static_cast<std::size_t>(ground_.rows->first[r + 1]); ++e) {
        const auto there = std::ranges::lower_bound(rows_, ground_.rows->neighbour[e]);
        if (there != rows_.end() && *there == ground_.rows->neighbour[e])
          entries.emplace_back(at, static_cast<int>(there - rows_.begin()),
                               ground_.K[static_cast<std::size_t>(ground_.rows->slot[e])]);
      }
    }
    Eigen::SparseMatrix<double> K(std::ssize(rows_), std::ssize(rows_));
    K.setFromTriplets(entries.begin(), entries.end());
    factor_.compute(K);
    ok_ = factor_.info() == Eigen::Success;
  }

  const DragGround& ground_;
  std::vector<std::int32_t> rows_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  bool ok_ = false;
};

// What one pass changed.
struct Step {
  double largest = 0.0;           // over the scale
  Eigen::RowVectorXd ofColumn;    // the same, of each
  std::vector<std::int32_t> row;  // twice, where both halves of the columns changed
  std::vector<double> change;     // largest of each row, over the scale
};

// X += L⁻ᵀ Z, half of the columns beside the other.
Step correct(const Tree& tree, const Tree::Path& path, const Tree::Block& Z, double tolerance,
             const Eigen::Ref<const Eigen::VectorXd>& scale,
             std::array<Tree::Workspace, 2>& workspace, FieldMatrix& X) {
  std::array<Step, 2> half;
  const Eigen::Index middle = (X.cols() + 1) / 2;
  parallelFor(
      2,
      [&](std::int64_t i) {
        const auto k = static_cast<std::size_t>(i);
        const Eigen::Index begin = i == 0 ? 0 : middle;
        const Eigen::Index count = i == 0 ? middle : X.cols() - middle;
        if (count == 0) return;
        const Tree::Answer answer =
            tree.backward(path, Z.middleCols(begin, count), tolerance, workspace[k]);
        const Eigen::RowVectorXd over = scale.segment(begin, count).cwiseInverse().transpose();
        Step& own = half[k];
        own.row = answer.row;
        own.ofColumn = Eigen::RowVectorXd::Zero(count);
        Eigen::RowVectorXd change(count);
        for (std::size_t a = 0; a < answer.row.size(); ++a) {
          change = answer.value.row(static_cast<Eigen::Index>(a)).cast<double>();
          X.row(answer.row[a]).segment(begin, count) += change;
          change = change.cwiseAbs().cwiseProduct(over);
          own.ofColumn = own.ofColumn.cwiseMax(change);
          own.change.push_back(change.maxCoeff());
          own.largest = std::max(own.largest, own.change.back());
        }
      },
      1);
  Step out = std::move(half[0]);
  out.largest = std::max(out.largest, half[1].largest);
  out.ofColumn.conservativeResize(X.cols());
  if (middle < X.cols()) out.ofColumn.tail(X.cols() - middle) = half[1].ofColumn;
  out.row.insert(out.row.end(), half[1].row.begin(), half[1].row.end());
  out.change.insert(out.change.end(), half[1].change.begin(), half[1].change.end());
  return out;
}

// Some columns of a problem, put together: a pass over all rows costs what they cost.
struct Columns {
  std::vector<Eigen::Index> which;  // ascending
  SparseSides b;
  Eigen::VectorXd scale;
  FieldMatrix X;

  Columns(std::vector<Eigen::Index> some, const SparseSides& all,
          const Eigen::Ref<const Eigen::VectorXd>& scales, const FieldMatrix& values)
      : which(std::move(some)), b(all.some(which)), scale(scales(which)) {
    X.resize(values.rows(), std::ssize(which));
    parallelFor(values.rows(), [&](std::int64_t r) {
      for (std::size_t c = 0; c < which.size(); ++c)
        X(r, static_cast<Eigen::Index>(c)) = values(r, which[c]);
    });
  }
  void writeTo(FieldMatrix& values) const {
    parallelFor(values.rows(), [&](std::int64_t r) {
      for (std::size_t c = 0; c < which.size(); ++c)
        values(r, which[c]) = X(r, static_cast<Eigen::Index>(c));
    });
  }
};

}  // namespace

SparseSides SparseSides::some(const std::vector<Eigen::Index>& columns) const {
  SparseSides out;
  out.place = place;
  out.value = value(Eigen::all, columns);
  return out;
}

SparseSides::SparseSides(std::int32_t rowCount, std::vector<std::int32_t> rows,
                         Eigen::Index columns)
    : place(static_cast<std::size_t>(rowCount), -1) {
  std::ranges::sort(rows);
  const auto same = std::ranges::unique(rows);
  rows.erase(same.begin(), same.end());
  for (std::size_t i = 0; i < rows.size(); ++i)
    place[static_cast<std::size_t>(rows[i])] = static_cast<std::int32_t>(i);
  value.resize(std::ssize(rows), columns);
  parallelFor(value.rows(), [&](std::int64_t r) { value.row(r).setZero(); });
}

SparseSides sidesOf(const mesh::TetMesh& mesh, const mesh::StiffnessPattern& pattern,
                    const std::vector<CoreSample>& samples, const FieldMatrix& worth) {
  EC_REQUIRE_EQ(std::ssize(samples), worth.rows());
  const auto rowOf = [&](const CoreSample& s, int k) {
    return pattern.row[static_cast<std::size_t>(mesh.T(s.tet, k))];
  };
  std::vector<std::int32_t> rows;
  for (const CoreSample& s : samples) {
    for (int k = 0; k < 4; ++k) {
      if (rowOf(s, k) >= 0) rows.push_back(rowOf(s, k));
    }
  }
  SparseSides out(pattern.rowCount(), std::move(rows), worth.cols());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (int k = 0; k < 4; ++k) {
      if (rowOf(samples[i], k) < 0) continue;
      out.value.row(out.place[static_cast<std::size_t>(rowOf(samples[i], k))]) +=
          samples[i].weight * samples[i].barycentric[k] * worth.row(static_cast<Eigen::Index>(i));
    }
  }
  return out;
}

std::vector<std::int32_t> rowsThatDiffer(const mesh::StiffnessPattern& pattern,
                                         const std::vector<double>& before,
                                         const std::vector<double>& after) {
  const SparseSides none(pattern.rowCount(), {}, 0);
  return rowsThatDiffer(pattern, before, none, after, none);
}

std::vector<std::int32_t> rowsThatDiffer(const mesh::StiffnessPattern& pattern,
                                         const std::vector<double>& before,
                                         const SparseSides& sidesBefore,
                                         const std::vector<double>& after,
                                         const SparseSides& sidesAfter) {
  EC_REQUIRE_EQ(before.size(), after.size());
  EC_REQUIRE_EQ(sidesBefore.value.cols(), sidesAfter.value.cols());
  std::vector<std::uint8_t> is(static_cast<std::size_t>(pattern.rowCount()), 0);
  const auto differs = [&](std::size_t r) {
    std::atomic_ref(is[r]).store(1, std::memory_order_relaxed);
  };
  parallelFor(pattern.rowCount(), [&](std::int64_t row) {
    const auto r = static_cast<std::size_t>(row);
    for (auto e = static_cast<std::size_t>(pattern.first[r]);
         e < static_cast<std::size_t>(pattern.first[r + 1]) && !before.empty(); ++e) {
      if (before[e] == after[e]) continue;
      differs(r);
      differs(static_cast<std::size_t>(pattern.index[e]));
    }
    const std::int32_t then = sidesBefore.place[r];
    const std::int32_t now = sidesAfter.place[r];
    if (then < 0 && now < 0) return;
    if (then < 0 || now < 0 || sidesBefore.value.row(then) != sidesAfter.value.row(now)) differs(r);
  });
  std::vector<std::int32_t> out;
  for (std::size_t r = 0; r < is.size(); ++r) {
    if (is[r] != 0) out.push_back(static_cast<std::int32_t>(r));
  }
  return out;
}

Refined refinedSolve(const DragGround& ground, const SparseSides& b,
                     const Eigen::Ref<const Eigen::VectorXd>& scale, FieldMatrix& X,
                     const std::function<bool()>& stop, std::span<const std::int32_t> changed,
                     bool allColumns) {
  EC_REQUIRE(std::ssize(b.place) == X.rows() && b.value.cols() == X.cols() &&
             scale.size() == X.cols());
  Refined out;
  const Tree& tree = ground.tree;
  std::array<Tree::Workspace, 2> workspace;
  // Rows of curves are among those that 32 bits are few for, and are right once they are solved for
  std::vector<std::int32_t> start;
  {
    std::vector<std::int32_t> own(changed.begin(), changed.end());
    std::ranges::sort(own);
    if (own.size() > kMostStubborn) own.clear();
    std::ranges::set_union(ground.stubborn, own, std::back_inserter(start));
  }
  Stubborn stubborn(ground, std::move(start));
  out.stubborn = ground.stubborn;
  double before = std::numeric_limits<double>::infinity();
  double visited = 0.0;
  const double usual = X.rows() > 0 ? usualDiagonal(ground) : 0.0;
  std::vector<std::int32_t> near;
  const double tolerance = X.cols() > 0 ? kNoCorrection * scale.minCoeff() : 0.0;
  std::optional<Columns> few;
  const auto solveStubborn = [&] { few ? stubborn.solve(few->b, few->X) : stubborn.solve(b, X); };
  while (out.passes < kMostPasses) {
    if (stop && stop()) return out;
    const bool some = out.passes == 0 && !changed.empty();
    std::span<const std::int32_t> where = ground.symbolic->order();
    if (some) where = changed;
    // From the third pass on all rows have been looked at
    if (out.passes > 1) where = near;
    const mesh::SparseColumns left =
        few ? residual(ground, few->b, few->scale, few->X, where, usual)
            : residual(ground, b, scale, X, where, usual);
    if (left.row.empty() && !some) {
      out.done = true;
      break;
    }
    if (stop && stop()) return out;
    const Tree::Path path = tree.pathOf(left.row);
    const Tree::Block Z = tree.forward(path, left);
    if (stop && stop()) return out;
    const Step step = few ? correct(tree, path, Z, tolerance, few->scale, workspace, few->X)
                          : correct(tree, path, Z, tolerance, scale, workspace, X);
    ++out.passes;
    out.lastStep = step.largest;
    visited += static_cast<double>(step.row.size()) / 2.0 / static_cast<double>(X.rows());
    // The next pass would change this times as much, and slow ones are dealt with
    const double next = out.lastStep * std::max(kSlow, out.lastStep / before);
    if (changed.empty() ? out.lastStep < kLearned : out.passes > 1 && next < kDone) {
      solveStubborn();
      out.done = true;
      break;
    }
    if (out.lastStep > kSlow * before) {
      // Neither stubborn rows nor a better start help: 32 bits are too few
      if (out.lastStep > kHopeless && out.lastStep > 0.5 * before) break;
      std::vector<std::int32_t> slow;
      for (std::size_t i = 0; i < step.row.size(); ++i) {
        if (step.change[i] > kStubborn * out.lastStep) slow.push_back(step.row[i]);
      }
      const auto more = stubborn.add(std::move(slow));
      std::vector<std::int32_t> all;
      std::ranges::set_union(out.stubborn, more, std::back_inserter(all));
      out.stubborn = std::move(all);
    }
    solveStubborn();
    before = out.lastStep;
    if (some && !allColumns) {
      std::vector<Eigen::Index> moved;
      for (Eigen::Index c = 0; c < X.cols(); ++c) {
        if (step.ofColumn[c] > kNoCorrection) moved.push_back(c);
      }
      if (!moved.empty() &&
          static_cast<double>(moved.size()) < kMostColumns * static_cast<double>(X.cols()))
        few.emplace(std::move(moved), b, scale, X);
    }
    std::vector<std::int32_t> touched = stubborn.rows();
    touched.insert(touched.end(), step.row.begin(), step.row.end());
    near = withNeighbours(ground, touched);
  }
  if (few) {
    few->writeTo(X);
    out.leftOut = X.cols() - std::ssize(few->which);
  }
  // As close as corrections go that are followed at all
  if (!out.done && out.passes == kMostPasses) out.done = out.lastStep < kDone;
  if (out.passes > 0) out.visitedShare = visited / out.passes;
  return out;
}

}  // namespace ecorche::tissue
