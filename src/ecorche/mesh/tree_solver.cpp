#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/cholesky_impl.h>
#include <ecorche/mesh/single_cholesky.h>
#include <ecorche/mesh/tree_solver.h>

#include <xmmintrin.h>

#include <algorithm>
#include <type_traits>

// Letters: L factor, K = P L Lᵀ Pᵀ. Nodes are supernodes (cholesky_impl.h); rows in the order of L.

namespace ecorche::mesh {

namespace {

// C −= A Bᵀ or A B, column by column
void subtractProduct(CBLAS_TRANSPOSE transB, int m, int n, int k, const float* A, int lda,
                     const float* B, int ldb, float beta, float* C, int ldc) {
  cblas_sgemm(CblasColMajor, CblasNoTrans, transB, m, n, k, -1.0F, A, lda, B, ldb, beta, C, ldc);
}
void subtractProduct(CBLAS_TRANSPOSE transB, int m, int n, int k, const double* A, int lda,
                     const double* B, int ldb, double beta, double* C, int ldc) {
  cblas_dgemm(CblasColMajor, CblasNoTrans, transB, m, n, k, -1.0, A, lda, B, ldb, beta, C, ldc);
}

// X ← X L⁻ᵀ or X L⁻¹
void divide(CBLAS_TRANSPOSE trans, int m, int n, const float* L, int ldl, float* X, int ldx) {
  cblas_strsm(CblasColMajor, CblasRight, CblasLower, trans, CblasNonUnit, m, n, 1.0F, L, ldl, X,
              ldx);
}
void divide(CBLAS_TRANSPOSE trans, int m, int n, const double* L, int ldl, double* X, int ldx) {
  cblas_dtrsm(CblasColMajor, CblasRight, CblasLower, trans, CblasNonUnit, m, n, 1.0, L, ldl, X,
              ldx);
}

// C += B M, all row by row
void addTimes(const float* B, const float* M, int rows, int k, int n, float* C) {
  cblas_sgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, rows, n, k, 1.0F, B, k, M, n, 1.0F, C, n);
}
void addTimes(const double* B, const double* M, int rows, int k, int n, double* C) {
  cblas_dgemm(CblasRowMajor, CblasNoTrans, CblasNoTrans, rows, n, k, 1.0, B, k, M, n, 1.0, C, n);
}

// C += Aᵀ B, A and B row by row, C column by column
void addProduct(const float* A, const float* B, int rows, int m, int n, float* C) {
  cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, m, n, rows, 1.0F, A, m, B, n, 1.0F, C, m);
}
void addProduct(const double* A, const double* B, int rows, int m, int n, double* C) {
  cblas_dgemm(CblasColMajor, CblasNoTrans, CblasTrans, m, n, rows, 1.0, A, m, B, n, 1.0, C, m);
}

// Columns fade along their way to numbers that processors are a hundred times slower with: they are
// nothing.
class FlushDenormals {
 public:
  FlushDenormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040U); }
  ~FlushDenormals() { _mm_setcsr(before_); }
  FlushDenormals(const FlushDenormals&) = delete;
  FlushDenormals& operator=(const FlushDenormals&) = delete;

 private:
  unsigned before_;
};

}  // namespace

template <class Scalar>
struct TreeSolver<Scalar>::Impl : Supernodes {
  std::shared_ptr<const void> factor;  // that the rest points into
  std::vector<Scalar> copied;
  std::vector<const Scalar*> panel;  // #nodes

  explicit Impl(const cholmod_factor& L) : Supernodes(L) {}

  // Where each of a path's nodes has its rows in a block; −1 off the path
  [[nodiscard]] std::vector<std::int32_t> placeOf(const Path& path) const {
    std::vector<std::int32_t> place(static_cast<std::size_t>(nodeCount), -1);
    for (std::size_t i = 0; i < path.node.size(); ++i)
      place[static_cast<std::size_t>(path.node[i])] = path.first[i];
    return place;
  }
  // Columns [begin, end) of Z
  void forward(const Path& path, const std::vector<std::int32_t>& place,
               const SparseColumns& columns, std::int32_t begin, std::int32_t end, Block& Z) const {
    if (begin >= end) return;
    const FlushDenormals flush;
    const auto width = static_cast<std::ptrdiff_t>(Z.cols());
    // Columns that have come by at a node lie between lo and hi: those side by side share most of
    // their way
    std::vector<std::int32_t> lo(static_cast<std::size_t>(nodeCount), end);
    std::vector<std::int32_t> hi(static_cast<std::size_t>(nodeCount), begin);
    for (std::int32_t c = begin; c < end; ++c) {
      for (auto i = static_cast<std::size_t>(columns.first[static_cast<std::size_t>(c)]);
           i < static_cast<std::size_t>(columns.first[static_cast<std::size_t>(c) + 1]); ++i) {
        const std::int32_t r = inverse[static_cast<std::size_t>(columns.row[i])];
        const auto node = static_cast<std::size_t>(nodeOf[static_cast<std::size_t>(r)]);
        EC_ASSERT(place[node] >= 0, "row {} lies off the path", columns.row[i]);
        Z(place[node] + r - super[node], c) += static_cast<Scalar>(columns.value[i]);
        lo[node] = std::min(lo[node], c);
        hi[node] = std::max(hi[node], c + 1);
      }
    }
    std::vector<Scalar> below;
    for (const std::int32_t node : path.node) {
      const auto k = static_cast<std::size_t>(node);
      const std::int32_t m = hi[k] - lo[k];
      if (m <= 0) continue;
      const std::int32_t c = this->columns(node);
      const std::int32_t r = rows(node);
      const Scalar* L = panel[k];
      Scalar* y = Z.data() + place[k] * width + lo[k];
      divide(CblasTrans, m, c, L, r, y, static_cast<int>(width));
      if (r == c) continue;
      below.resize(static_cast<std::size_t>(m) * static_cast<std::size_t>(r - c));
      subtractProduct(CblasTrans, m, r - c, c, y, static_cast<int>(width), L + c, r, Scalar(0),
                      below.data(), m);
      for (std::int32_t j = 0; j < r - c; ++j) {
        const std::int32_t row = s[pi[node] + c + j];
        const auto to = static_cast<std::size_t>(nodeOf[static_cast<std::size_t>(row)]);
        Scalar* z = Z.data() + (place[to] + row - super[to]) * width + lo[k];
        const Scalar* t = below.data() + static_cast<std::ptrdiff_t>(j) * m;
        for (std::int32_t i = 0; i < m; ++i) z[i] += t[i];
        lo[to] = std::min(lo[to], lo[k]);
        hi[to] = std::max(hi[to], hi[k]);
      }
    }
  }
  [[nodiscard]] Path pathOfNodes(const std::vector<std::uint8_t>& on) const {
    Path path;
    path.first.push_back(0);
    for (std::int32_t node = 0; node < nodeCount; ++node) {
      if (on[static_cast<std::size_t>(node)] == 0) continue;
      path.node.push_back(node);
      path.first.push_back(path.first.back() + columns(node));
    }
    return path;
  }
};

template <class Scalar>
TreeSolver<Scalar>::TreeSolver(std::shared_ptr<const Cholesky> factor) {
  EC_REQUIRE(factor != nullptr && factor->ok());
  const cholmod_factor& L = *factor->impl_->L;
  impl_ = std::make_unique<Impl>(L);
  Impl& I = *impl_;
  I.factor = std::move(factor);
  const auto* values = static_cast<const double*>(L.x);
  const Scalar* x = nullptr;
  if constexpr (std::is_same_v<Scalar, double>) {
    x = values;
  } else {
    I.copied.assign(values, values + L.xsize);
    x = I.copied.data();
  }
  for (std::int32_t node = 0; node < I.nodeCount; ++node) I.panel.push_back(x + I.px[node]);
}
template <class Scalar>
TreeSolver<Scalar>::TreeSolver(
    std::shared_ptr<const SingleCholesky> factor) requires std::is_same_v<Scalar, float> {
  EC_REQUIRE(factor != nullptr && factor->ok());
  impl_ = std::make_unique<Impl>(factor->symbolicFactor());
  impl_->panel = factor->panels();
  impl_->factor = std::move(factor);
}
template <class Scalar>
TreeSolver<Scalar>::~TreeSolver() = default;
template <class Scalar>
std::size_t TreeSolver<Scalar>::copiedBytes() const {
  return impl_->copied.size() * sizeof(Scalar);
}
template <class Scalar>
TreeSolver<Scalar>::TreeSolver(TreeSolver&&) noexcept = default;
template <class Scalar>
TreeSolver<Scalar>& TreeSolver<Scalar>::operator=(TreeSolver&&) noexcept = default;

template <class Scalar>
auto TreeSolver<Scalar>::pathOf(std::span<const std::int32_t> rows) const -> Path {
  const Impl& I = *impl_;
  std::vector<std::uint8_t> on(static_cast<std::size_t>(I.nodeCount), 0);
  for (const std::int32_t r : rows) {
    for (std::int32_t node =
             I.nodeOf[static_cast<std::size_t>(I.inverse[static_cast<std::size_t>(r)])];
         node >= 0 && on[static_cast<std::size_t>(node)] == 0;
         node = I.parent[static_cast<std::size_t>(node)])
      on[static_cast<std::size_t>(node)] = 1;
  }
  return I.pathOfNodes(on);
}

template <class Scalar>
auto TreeSolver<Scalar>::join(const Path& a, const Path& b) const -> Path {
  std::vector<std::uint8_t> on(static_cast<std::size_t>(impl_->nodeCount), 0);
  for (const std::int32_t node : a.node) on[static_cast<std::size_t>(node)] = 1;
  for (const std::int32_t node : b.node) on[static_cast<std::size_t>(node)] = 1;
  return impl_->pathOfNodes(on);
}

template <class Scalar>
auto TreeSolver<Scalar>::forward(const Path& path, const SparseColumns& columns) const -> Block {
  const Impl& I = *impl_;
  const BlasThreads blas(1);
  const std::vector<std::int32_t> place = I.placeOf(path);
  const auto width = static_cast<std::int32_t>(columns.count());
  Block Z = Block::Zero(path.rowCount(), width);
  parallelFor(
      2,
      [&](std::int64_t half) {
        I.forward(path, place, columns, half == 0 ? 0 : (width + 1) / 2,
                  half == 0 ? (width + 1) / 2 : width, Z);
      },
      1);
  return Z;
}

template <class Scalar>
Eigen::MatrixXd TreeSolver<Scalar>::product(const Path& pathA, const Block& A, const Path& pathB,
                                            const Block& B) const {
  const BlasThreads blas(1);
  const FlushDenormals flush;
  using Product = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  Product sum = Product::Zero(A.cols(), B.cols());
  if (sum.size() == 0) return sum.template cast<double>();
  for (std::size_t a = 0, b = 0; a < pathA.node.size() && b < pathB.node.size();) {
    if (pathA.node[a] < pathB.node[b]) {
      ++a;
    } else if (pathB.node[b] < pathA.node[a]) {
      ++b;
    } else {
      // Nodes that follow each other on both paths are one block
      std::size_t n = 0;
      while (a + n < pathA.node.size() && b + n < pathB.node.size() &&
             pathA.node[a + n] == pathB.node[b + n])
        ++n;
      const Eigen::Index rows = pathA.first[a + n] - pathA.first[a];
      addProduct(A.data() + pathA.first[a] * A.cols(), B.data() + pathB.first[b] * B.cols(),
                 static_cast<int>(rows), static_cast<int>(A.cols()), static_cast<int>(B.cols()),
                 sum.data());
      a += n;
      b += n;
    }
  }
  return sum.template cast<double>();
}

template <class Scalar>
void TreeSolver<Scalar>::accumulate(const Path& path, const Block& B, const Eigen::MatrixXd& M,
                                    const Path& onto, Block& sum) const {
  EC_REQUIRE(B.cols() == M.rows() && sum.cols() == M.cols());
  if (M.size() == 0) return;
  const BlasThreads blas(1);
  const FlushDenormals flush;
  const Block m = M.template cast<Scalar>();
  std::size_t a = 0;
  for (std::size_t b = 0; b < path.node.size();) {
    while (a < onto.node.size() && onto.node[a] < path.node[b]) ++a;
    EC_REQUIRE(a < onto.node.size() && onto.node[a] == path.node[b]);
    std::size_t n = 0;
    while (a + n < onto.node.size() && b + n < path.node.size() &&
           onto.node[a + n] == path.node[b + n])
      ++n;
    const Eigen::Index rows = path.first[b + n] - path.first[b];
    addTimes(B.data() + path.first[b] * B.cols(), m.data(), static_cast<int>(rows),
             static_cast<int>(m.rows()), static_cast<int>(m.cols()),
             sum.data() + onto.first[a] * sum.cols());
    a += n;
    b += n;
  }
}

template <class Scalar>
auto TreeSolver<Scalar>::backward(const Path& path, const Block& block, double tolerance,
                                  Workspace& workspace) const -> Answer {
  const Impl& I = *impl_;
  const BlasThreads blas(1);
  const FlushDenormals flush;
  const std::vector<std::int32_t> place = I.placeOf(path);
  const auto width = static_cast<std::int32_t>(block.cols());
  if (width == 0) return {{}, Block(0, 0)};
  // Written where a node is visited, and read there only
  const std::size_t size = static_cast<std::size_t>(I.n) * static_cast<std::size_t>(width);
  if (workspace.x.size() < size) workspace.x.resize(size);
  Scalar* const X = workspace.x.data();
  std::vector<std::uint8_t>& visited = workspace.visited;
  visited.assign(static_cast<std::size_t>(I.nodeCount), 0);
  std::vector<Scalar>& above = workspace.above;
  std::vector<Scalar> largest(static_cast<std::size_t>(width));
  std::vector<std::int32_t> active;  // columns that are something above a node
  std::vector<Scalar> values;
  std::vector<std::int32_t> nodes;
  Eigen::Index count = 0;
  for (std::int32_t node = I.nodeCount - 1; node >= 0; --node) {
    const auto k = static_cast<std::size_t>(node);
    const std::int32_t parent = I.parent[k];
    const bool loaded = place[k] >= 0;
    if (!loaded && (parent < 0 || visited[static_cast<std::size_t>(parent)] == 0)) continue;
    const std::int32_t c = I.columns(node);
    const std::int32_t below = I.rows(node) - c;
    const std::int32_t* rowsAbove = I.s + I.pi[node] + c;
    active.clear();
    if (loaded) {
      for (std::int32_t i = 0; i < width; ++i) active.push_back(i);
    } else {
      std::ranges::fill(largest, Scalar(0));
      for (std::int32_t j = 0; j < below; ++j) {
        const Scalar* from = X + static_cast<std::ptrdiff_t>(rowsAbove[j]) * width;
        for (std::int32_t i = 0; i < width; ++i) {
          Scalar& most = largest[static_cast<std::size_t>(i)];
          most = std::max(most, std::abs(from[i]));
        }
      }
      for (std::int32_t i = 0; i < width; ++i) {
        if (!(static_cast<double>(largest[static_cast<std::size_t>(i)]) < tolerance))
          active.push_back(i);
      }
      if (active.empty()) continue;
    }
    visited[k] = 1;
    nodes.push_back(node);
    count += c;
    const auto m = static_cast<std::int32_t>(active.size());
    above.resize(static_cast<std::size_t>(m) * static_cast<std::size_t>(below));
    Scalar* to = above.data();
    for (std::int32_t j = 0; j < below; ++j) {
      const Scalar* from = X + static_cast<std::ptrdiff_t>(rowsAbove[j]) * width;
      for (const std::int32_t i : active) *to++ = from[i];
    }
    values.assign(static_cast<std::size_t>(m) * static_cast<std::size_t>(c), Scalar(0));
    if (loaded) {
      std::copy_n(block.data() + static_cast<std::ptrdiff_t>(place[k]) * width,
                  static_cast<std::ptrdiff_t>(c) * width, values.begin());
    }
    const Scalar* L = I.panel[k];
    if (below > 0)
      subtractProduct(CblasNoTrans, m, c, below, above.data(), m, L + c, c + below, Scalar(1),
                      values.data(), m);
    divide(CblasNoTrans, m, c, L, c + below, values.data(), m);
    Scalar* y = X + static_cast<std::ptrdiff_t>(I.super[node]) * width;
    if (m < width) std::fill_n(y, static_cast<std::ptrdiff_t>(c) * width, Scalar(0));
    const Scalar* value = values.data();
    for (std::int32_t row = 0; row < c; ++row, y += width) {
      for (const std::int32_t i : active) y[i] = *value++;
    }
  }
  Answer out;
  out.row.reserve(static_cast<std::size_t>(count));
  out.value.resize(count, width);
  for (const std::int32_t node : nodes) {
    for (std::int32_t c = I.super[node]; c < I.super[node + 1]; ++c) {
      std::copy_n(X + static_cast<std::ptrdiff_t>(c) * width, width,
                  out.value.row(std::ssize(out.row)).data());
      out.row.push_back(I.perm[c]);
    }
  }
  return out;
}

template class TreeSolver<float>;
template class TreeSolver<double>;

}  // namespace ecorche::mesh
