#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/cholesky_impl.h>

#include <algorithm>
#include <mutex>
#include <vector>

namespace ecorche::mesh {

namespace {

// Most columns per block of a solve: the factor is read once per block. Blocks are the same for any
// number of threads, so that results are, too.
constexpr Eigen::Index kBlock = 16;

}  // namespace

cholmod_sparse SymbolicCholesky::Impl::view(const double* values) const {
  cholmod_sparse K{};
  K.nrow = K.ncol = first.size() - 1;
  K.nzmax = index.size();
  K.p = const_cast<std::int32_t*>(first.data());
  K.i = const_cast<std::int32_t*>(index.data());
  K.x = const_cast<double*>(values);
  K.stype = -1;
  K.itype = CHOLMOD_INT;
  K.xtype = values != nullptr ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  K.dtype = CHOLMOD_DOUBLE;
  K.sorted = 1;
  K.packed = 1;
  return K;
}

Supernodes::Supernodes(const cholmod_factor& L)
    : n(static_cast<std::int32_t>(L.n)),
      nodeCount(static_cast<std::int32_t>(L.nsuper)),
      perm(static_cast<const std::int32_t*>(L.Perm)),
      super(static_cast<const std::int32_t*>(L.super)),
      pi(static_cast<const std::int32_t*>(L.pi)),
      px(static_cast<const std::int32_t*>(L.px)),
      s(static_cast<const std::int32_t*>(L.s)),
      inverse(L.n),
      nodeOf(L.n),
      parent(L.nsuper, -1) {
  EC_REQUIRE(L.is_super != 0);
  for (std::int32_t i = 0; i < n; ++i) inverse[static_cast<std::size_t>(perm[i])] = i;
  for (std::int32_t node = 0; node < nodeCount; ++node) {
    for (std::int32_t c = super[node]; c < super[node + 1]; ++c)
      nodeOf[static_cast<std::size_t>(c)] = node;
  }
  for (std::int32_t node = 0; node < nodeCount; ++node) {
    if (rows(node) > columns(node))
      parent[static_cast<std::size_t>(node)] =
          nodeOf[static_cast<std::size_t>(s[pi[node] + columns(node)])];
  }
}

SymbolicCholesky::SymbolicCholesky(const StiffnessPattern& pattern, Ordering ordering) {
  auto impl = std::make_shared<Impl>();
  impl->common.c.method[0].ordering =
      ordering == Ordering::MinimumDegree ? CHOLMOD_AMD : CHOLMOD_METIS;
  impl->first = pattern.first;
  impl->index = pattern.index;
  cholmod_sparse K = impl->view(nullptr);
  {
    // METIS seeds the process' random numbers and draws from them: one analysis at a time gives one
    // ordering
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    impl->L = cholmod_analyze(&K, impl->common);
  }
  EC_REQUIRE(impl->L != nullptr);
  impl_ = std::move(impl);
}
SymbolicCholesky::SymbolicCholesky(const StiffnessPattern& pattern,
                                   std::span<const std::int32_t> order) {
  EC_REQUIRE_EQ(std::ssize(order), pattern.rowCount());
  auto impl = std::make_shared<Impl>();
  impl->common.c.method[0].ordering = CHOLMOD_GIVEN;
  impl->first = pattern.first;
  impl->index = pattern.index;
  cholmod_sparse K = impl->view(nullptr);
  impl->L =
      cholmod_analyze_p(&K, const_cast<std::int32_t*>(order.data()), nullptr, 0, impl->common);
  EC_REQUIRE(impl->L != nullptr);
  impl_ = std::move(impl);
}
SymbolicCholesky::~SymbolicCholesky() = default;
SymbolicCholesky::SymbolicCholesky(const SymbolicCholesky&) = default;
SymbolicCholesky::SymbolicCholesky(SymbolicCholesky&&) noexcept = default;
SymbolicCholesky& SymbolicCholesky::operator=(SymbolicCholesky&&) noexcept = default;

std::int64_t SymbolicCholesky::rowCount() const {
  return static_cast<std::int64_t>(impl_->first.size()) - 1;
}
std::span<const std::int32_t> SymbolicCholesky::order() const {
  return {static_cast<const std::int32_t*>(impl_->L->Perm), impl_->L->n};
}
double SymbolicCholesky::factorEntries() const { return static_cast<double>(impl_->L->xsize); }

Cholesky::Cholesky(const SymbolicCholesky& symbolic, const std::vector<double>& values, int threads)
    : impl_(std::make_unique<Impl>()) {
  EC_REQUIRE_EQ(values.size(), symbolic.impl_->index.size());
  const BlasThreads blas(threads > 0 ? threads : threadCount());
  impl_->rowCount = symbolic.rowCount();
  cholmod_sparse K = symbolic.impl_->view(values.data());
  impl_->L = cholmod_copy_factor(symbolic.impl_->L, impl_->common);
  EC_REQUIRE(impl_->L != nullptr);
  cholmod_factorize(&K, impl_->L, impl_->common);
  if (impl_->common.c.status != CHOLMOD_OK) {
    // CHOLMOD stops at the first pivot that is not positive; the place is an index into its own
    // ordering
    const auto n = static_cast<std::size_t>(impl_->rowCount);
    const std::size_t at = std::min(impl_->L->minor, n - 1);
    impl_->badRow = static_cast<const std::int32_t*>(impl_->L->Perm)[at];
  }
}
Cholesky::~Cholesky() = default;
Cholesky::Cholesky(Cholesky&&) noexcept = default;
Cholesky& Cholesky::operator=(Cholesky&&) noexcept = default;

std::size_t Cholesky::bytes() const { return impl_->L->xsize * sizeof(double); }
bool Cholesky::ok() const { return impl_->badRow < 0; }
std::int64_t Cholesky::badRow() const { return impl_->badRow; }

void Cholesky::solveInPlace(Eigen::MatrixXd& X, const std::function<bool()>& stop) const {
  EC_REQUIRE(ok());
  EC_REQUIRE_EQ(X.rows(), impl_->rowCount);
  const BlasThreads blas(1);
  if (X.cols() == 0) return;
  const Eigen::Index blockCount = (X.cols() + kBlock - 1) / kBlock;
  const Eigen::Index blockWidth = (X.cols() + blockCount - 1) / blockCount;
  parallelFor(
      blockCount,
      [&](std::int64_t block) {
        if (stop && stop()) return;
        Common common;
        const Eigen::Index begin = block * blockWidth;
        const Eigen::Index width = std::min(blockWidth, X.cols() - begin);
        if (width <= 0) return;
        cholmod_dense b{};
        b.nrow = b.d = static_cast<std::size_t>(X.rows());
        b.ncol = static_cast<std::size_t>(width);
        b.nzmax = b.nrow * b.ncol;
        b.x = X.col(begin).data();
        b.xtype = CHOLMOD_REAL;
        b.dtype = CHOLMOD_DOUBLE;
        cholmod_dense* x = cholmod_solve(CHOLMOD_A, impl_->L, &b, common);
        EC_REQUIRE(x != nullptr);
        std::copy_n(static_cast<const double*>(x->x), b.nzmax, X.col(begin).data());
        cholmod_free_dense(&x, common);
      },
      1);
}

}  // namespace ecorche::mesh
