#pragma once

#include <ecorche/mesh/cholesky.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace ecorche::mesh {

class SingleCholesky;

/// Columns of a right side that is nothing in most rows.
struct SparseColumns {
  std::vector<std::int32_t> first{0};  ///< #columns+1
  std::vector<std::int32_t> row;       ///< #entries
  std::vector<double> value;           ///< #entries

  [[nodiscard]] Eigen::Index count() const { return std::ssize(first) - 1; }
  void add(std::int32_t r, double v) {
    row.push_back(r);
    value.push_back(v);
  }
  void endColumn() { first.push_back(static_cast<std::int32_t>(row.size())); }
};

/// Solves with a Cholesky factor where right sides are nothing in most rows and answers are asked
/// for where they are something.
///
/// Eliminating a row is felt by its ancestors in the elimination tree alone [Gilbert & Peierls
/// 1988; Davis 2006, §4]: L⁻¹ b has entries on the way from b's rows to the root, which in three
/// dimensions is a small part of the factor. On the way back every subtree sees the rest of the
/// domain only through its ancestors' values. Where these are smaller than a tolerance so is all
/// that hangs below, by the maximum principle, and the subtree is left out.
///
/// @tparam Scalar  float: a copy of the factor in half the memory, twice as fast; double: the
/// factor itself
template <class Scalar>
class TreeSolver {
 public:
  /// @param factor  ok(); kept
  explicit TreeSolver(std::shared_ptr<const Cholesky> factor);
  /// With a factor that was made in 32 bits: nothing is copied.
  explicit TreeSolver(
      std::shared_ptr<const SingleCholesky> factor) requires std::is_same_v<Scalar, float>;
  ~TreeSolver();
  [[nodiscard]] std::size_t copiedBytes() const;  ///< of its own copy of a factor's entries
  TreeSolver(TreeSolver&&) noexcept;
  TreeSolver& operator=(TreeSolver&&) noexcept;

  /// Nodes of the elimination tree from some rows to the root.
  struct Path {
    std::vector<std::int32_t> node;   ///< ascending: children before parents
    std::vector<std::int32_t> first;  ///< #nodes+1, place of its rows in a Block
    [[nodiscard]] Eigen::Index rowCount() const { return first.back(); }
  };
  /// Values on a path's rows, in its order.
  using Block = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  [[nodiscard]] Path pathOf(std::span<const std::int32_t> rows) const;
  [[nodiscard]] Path join(const Path& a, const Path& b) const;

  /// L⁻¹ of columns whose rows lie on the path. Columns that follow each other along a line, say,
  /// share most of their way: the first half of them is solved for beside the second.
  [[nodiscard]] Block forward(const Path& path, const SparseColumns& columns) const;
  /// Aᵀ B of blocks on two paths.
  [[nodiscard]] Eigen::MatrixXd product(const Path& pathA, const Block& A, const Path& pathB,
                                        const Block& B) const;
  /// onto += B M, for a path that lies on another.
  void accumulate(const Path& path, const Block& B, const Eigen::MatrixXd& M, const Path& onto,
                  Block& sum) const;

  /// L⁻ᵀ of a block, row by row of K, where it matters.
  struct Answer {
    std::vector<std::int32_t> row;  ///< of K
    Block value;                    ///< #row×#columns; what is nothing, here or in rows that are
                                    ///< left out, is smaller than the tolerance
  };
  /// What backward works in: one per thread that calls it, kept between calls.
  struct Workspace {
    std::vector<Scalar> x;
    std::vector<Scalar> above;
    std::vector<std::uint8_t> visited;
  };
  /// @param tolerance  0: every row
  [[nodiscard]] Answer backward(const Path& path, const Block& block, double tolerance,
                                Workspace& workspace) const;
  [[nodiscard]] Answer backward(const Path& path, const Block& block, double tolerance) const {
    Workspace workspace;
    return backward(path, block, tolerance, workspace);
  }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

extern template class TreeSolver<float>;
extern template class TreeSolver<double>;

}  // namespace ecorche::mesh
