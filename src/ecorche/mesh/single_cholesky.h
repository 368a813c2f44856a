#pragma once

#include <ecorche/mesh/cholesky.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

struct cholmod_factor_struct;

namespace ecorche::mesh {

/// K = P L Lᵀ Pᵀ in 32 bits: half the bytes and half the time, and what a solve with it is off by,
/// refinement in 64 bits takes away (tissue/settle.h).
///
/// Left-looking and supernodal [Ng & Peyton 1993], on CHOLMOD's ordering and supernodes. Subtrees
/// of the elimination tree are factored beside each other; near the root, where one panel is most
/// of the work, so are its slabs. Which they are does not depend on the number of threads, nor do
/// the bytes.
class SingleCholesky {
 public:
  /// @param values  #entries of the pattern
  /// @param stop    asked between subtrees; true ends with a factor that is not ok()
  SingleCholesky(const SymbolicCholesky& symbolic, const std::vector<double>& values,
                 const std::function<bool()>& stop = {});
  /// Where K is another one in some rows, those rows' ancestors in the elimination tree alone have
  /// other columns [Davis 2006, §4.3]: they are made anew, the others shared.
  /// @param values   #entries, in all but changed rows those of `before`
  /// @param changed  rows of K; every entry that is another one has both ends among them
  SingleCholesky(const std::shared_ptr<const SingleCholesky>& before,
                 const std::vector<double>& values, std::span<const std::int32_t> changed,
                 const std::function<bool()>& stop = {});
  ~SingleCholesky();
  SingleCholesky(const SingleCholesky&) = delete;
  SingleCholesky& operator=(const SingleCholesky&) = delete;

  /// False where K is not positive definite in 32 bits, or where it was stopped.
  [[nodiscard]] bool ok() const;
  /// What it holds of its own, beside what it shares with the one that it was made of [bytes].
  [[nodiscard]] std::size_t bytes() const;
  /// The one whose panels it shares; null: none.
  [[nodiscard]] const std::shared_ptr<const SingleCholesky>& before() const;
  /// Of the work of a whole factor, how much was done [0, 1].
  [[nodiscard]] double shareMade() const;
  /// How much it would be for another with these rows changed.
  [[nodiscard]] double shareOf(std::span<const std::int32_t> changed) const;

 private:
  template <class Scalar>
  friend class TreeSolver;
  struct Impl;
  std::unique_ptr<Impl> impl_;

  [[nodiscard]] std::vector<std::uint8_t> ancestors(std::span<const std::int32_t> changed) const;
  [[nodiscard]] const cholmod_factor_struct& symbolicFactor() const;
  [[nodiscard]] const std::vector<const float*>& panels() const;
};

}  // namespace ecorche::mesh
