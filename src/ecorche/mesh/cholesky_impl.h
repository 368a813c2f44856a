#pragma once

#include <cblas.h>
#include <cholmod.h>
#include <ecorche/mesh/cholesky.h>

#include <atomic>

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

struct Cholesky::Impl {
  mutable Common common;
  cholmod_factor* L = nullptr;
  std::int64_t rowCount = 0;
  std::int64_t badRow = -1;

  ~Impl() { cholmod_free_factor(&L, common); }
};

}  // namespace ecorche::mesh
