#pragma once

#include <cblas.h>
#include <cholmod.h>
#include <ecorche/mesh/cholesky.h>

#include <atomic>
#include <cstdint>
#include <vector>

// What the sources around CHOLMOD share; for them alone.

namespace ecorche::mesh {

// CHOLMOD's settings and workspace; one per call, since calls may come from several threads.
struct Common {
  cholmod_common c{};
  Common() {
    cholmod_start(&c);
    c.supernodal = CHOLMOD_SUPERNODAL;
    c.final_ll = 1;
    c.print = 0;
    c.error_handler = nullptr;
    c.nmethods = 1;
    c.method[0].ordering = CHOLMOD_METIS;
    c.postorder = 1;
  }
  ~Common() { cholmod_finish(&c); }
  Common(const Common&) = delete;
  Common& operator=(const Common&) = delete;
  operator cholmod_common*() { return &c; }
};

// OpenBLAS keeps one thread count for the whole process. It is 1 with us, so that our own loops can
// run beside one another, and wide only while a factorisation that stands alone asks for it.
class BlasThreads {
 public:
  explicit BlasThreads(int count) : wide_(count > 1) {
    if (wide_ ? users()++ == 0 : users() == 0) openblas_set_num_threads(count);
  }
  ~BlasThreads() {
    if (wide_ && --users() == 0) openblas_set_num_threads(1);
  }
  BlasThreads(const BlasThreads&) = delete;
  BlasThreads& operator=(const BlasThreads&) = delete;

 private:
  static std::atomic<int>& users() {
    static std::atomic<int> count{0};
    return count;
  }
  bool wide_;
};

// The symbolic factor as CHOLMOD lays it out, and what follows from it. A node is a supernode:
// columns with the same rows below them, kept as one dense panel of which the upper square is
// triangular.
struct Supernodes {
  std::int32_t n = 0;
  std::int32_t nodeCount = 0;
  // CHOLMOD's own; rows here are in its order
  const std::int32_t* perm = nullptr;
  const std::int32_t* super = nullptr;  // #nodes+1, first column
  const std::int32_t* pi = nullptr;     // #nodes+1, first of its rows in s
  const std::int32_t* px = nullptr;     // #nodes+1, first of its panel among all entries
  const std::int32_t* s = nullptr;
  std::vector<std::int32_t> inverse;
  std::vector<std::int32_t> nodeOf;
  std::vector<std::int32_t> parent;  // −1: a root

  /// @param L  supernodal; must outlive this
  explicit Supernodes(const cholmod_factor& L);

  [[nodiscard]] std::int32_t columns(std::int32_t node) const {
    return super[node + 1] - super[node];
  }
  [[nodiscard]] std::int32_t rows(std::int32_t node) const { return pi[node + 1] - pi[node]; }
};

struct SymbolicCholesky::Impl {
  mutable Common common;
  std::vector<std::int32_t> first;
  std::vector<std::int32_t> index;
  cholmod_factor* L = nullptr;

  ~Impl() { cholmod_free_factor(&L, common); }

  // The matrix as CHOLMOD sees it, over our own arrays
  [[nodiscard]] cholmod_sparse view(const double* values) const;
};

struct Cholesky::Impl {
  mutable Common common;
  cholmod_factor* L = nullptr;
  std::int64_t rowCount = 0;
  std::int64_t badRow = -1;

  ~Impl() { cholmod_free_factor(&L, common); }
};

}  // namespace ecorche::mesh
