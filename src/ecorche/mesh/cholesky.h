#pragma once

#include <ecorche/mesh/operators.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace ecorche::mesh {

/// How rows are ordered before they are eliminated.
enum class Ordering : std::uint8_t {
  /// METIS: least work for large systems. It seeds the process' random numbers and draws from them;
  /// analyses take turns,
  /// and only other users of rand() beside it could change the last bits of what is solved.
  NestedDissection,
  /// AMD: quicker to find, the same whatever runs beside it; for many systems of some ten thousand
  /// rows.
  MinimumDegree,
};

/// Fill-reducing ordering and elimination tree of a stiffness pattern: what all matrices on it
/// share.
///
/// CHOLMOD, supernodal [Chen, Davis, Hager, Rajamanickam 2008].
class SymbolicCholesky {
 public:
  /// Copies what it needs; the pattern may go away.
  explicit SymbolicCholesky(const StiffnessPattern& pattern,
                            Ordering ordering = Ordering::NestedDissection);
  /// With an ordering that is known already, say that of a larger pattern: much quicker to make.
  /// @param order  of the rows, each once
  SymbolicCholesky(const StiffnessPattern& pattern, std::span<const std::int32_t> order);
  ~SymbolicCholesky();
  SymbolicCholesky(const SymbolicCholesky&);  ///< shares what was found
  SymbolicCholesky(SymbolicCholesky&&) noexcept;
  SymbolicCholesky& operator=(SymbolicCholesky&&) noexcept;

  [[nodiscard]] std::int64_t rowCount() const;
  /// Rows as they are eliminated: those of one part of the mesh stand together.
  [[nodiscard]] std::span<const std::int32_t> order() const;
  /// Entries of the factor L.
  [[nodiscard]] double factorEntries() const;

 private:
  friend class Cholesky;
  friend class SingleCholesky;
  struct Impl;
  std::shared_ptr<const Impl> impl_;
};

/// K = P L Lᵀ Pᵀ for one set of values on a pattern that was analysed before.
class Cholesky {
 public:
  /// @param values   #entries of the pattern
  /// @param threads  for BLAS. Use 1 where several are factored at once. 0: as many as the process
  /// was given
  Cholesky(const SymbolicCholesky& symbolic, const std::vector<double>& values, int threads = 0);
  ~Cholesky();
  Cholesky(Cholesky&&) noexcept;
  Cholesky& operator=(Cholesky&&) noexcept;

  /// False where K is not positive definite in doubles; then badRow() is the row of the first pivot
  /// that is not positive.
  [[nodiscard]] bool ok() const;
  [[nodiscard]] std::int64_t badRow() const;
  [[nodiscard]] std::size_t bytes() const;  ///< of the factor's entries

  /// K X = right side, in place, blocks of columns in parallel. The bytes do not depend on the
  /// number of threads.
  /// @param stop  asked between blocks; true leaves the rest unsolved
  void solveInPlace(Eigen::MatrixXd& X, const std::function<bool()>& stop = {}) const;

 private:
  template <class Scalar>
  friend class TreeSolver;
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ecorche::mesh
