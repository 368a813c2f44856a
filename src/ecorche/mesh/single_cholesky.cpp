#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/cholesky_impl.h>
#include <ecorche/mesh/single_cholesky.h>

#include <algorithm>
#include <atomic>
#include <numeric>

// Of LAPACK's Cholesky factorisation CHOLMOD uses the same library's; it has no header of its own.
extern "C" void spotrf_(const char* uplo, const int* n, float* a, const int* lda, int* info);

namespace ecorche::mesh {

namespace {

// A subtree with more than this share of all work is not factored by one thread.
constexpr double kLargestSubtree = 1.0 / 24.0;
// Slabs of a panel near the root, and columns that are eliminated before the rest hears of it.
constexpr std::int32_t kSlabs = 4;
constexpr std::int32_t kColumns = 192;

// Part of a node that a node above it has to take off: rows [begin, end) of the lower one lie among
// the columns of the upper one.
struct Update {
  std::int32_t from = 0;
  std::int32_t begin = 0;
  std::int32_t end = 0;
};

// What all factors on one pattern share.
struct Plan {
  Supernodes tree;
  // Per node, ascending
  std::vector<std::int32_t> firstUpdate;
  std::vector<Update> update;
  // Per node: entries of K, and where in its panel they belong
  std::vector<std::int32_t> firstEntry;
  std::vector<std::int32_t> entry;
  std::vector<std::int32_t> place;
  std::vector<double> work;  // of each node [flops]
  // Subtrees that one thread each factors, the largest first, as nodes [begin, end): postorder
  std::vector<std::pair<std::int32_t, std::int32_t>> subtree;
  std::vector<std::int32_t> top;  // the other nodes, children first

  Plan(const cholmod_factor& L, const std::vector<std::int32_t>& first,
       const std::vector<std::int32_t>& index);

 private:
  void findUpdates();
  void placeEntries(const std::vector<std::int32_t>& first, const std::vector<std::int32_t>& index);
  void share();
};

Plan::Plan(const cholmod_factor& L, const std::vector<std::int32_t>& first,
           const std::vector<std::int32_t>& index)
    : tree(L) {
  findUpdates();
  placeEntries(first, index);
  share();
}

void Plan::findUpdates() {
  const auto nodes = static_cast<std::size_t>(tree.nodeCount);
  const auto each = [&](const auto& take) {
    for (std::int32_t d = 0; d < tree.nodeCount; ++d) {
      const std::int32_t* s = tree.s + tree.pi[d];
      const std::int32_t r = tree.rows(d);
      for (std::int32_t begin = tree.columns(d), end = begin; begin < r; begin = end) {
        const std::int32_t to = tree.nodeOf[static_cast<std::size_t>(s[begin])];
        while (end < r && s[end] < tree.super[to + 1]) ++end;
        take(to, Update{d, begin, end});
      }
    }
  };
  firstUpdate.assign(nodes + 1, 0);
  work.assign(nodes, 0.0);
  each([&](std::int32_t to, const Update& u) {
    ++firstUpdate[static_cast<std::size_t>(to) + 1];
    work[static_cast<std::size_t>(to)] +=
        2.0 * (u.end - u.begin) * (tree.rows(u.from) - u.begin) * tree.columns(u.from);
  });
  std::partial_sum(firstUpdate.begin(), firstUpdate.end(), firstUpdate.begin());
  update.resize(static_cast<std::size_t>(firstUpdate.back()));
  std::vector<std::int32_t> next(firstUpdate.begin(), firstUpdate.end() - 1);
  each([&](std::int32_t to, const Update& u) {
    update[static_cast<std::size_t>(next[static_cast<std::size_t>(to)]++)] = u;
  });
  for (std::int32_t node = 0; node < tree.nodeCount; ++node) {
    const double c = tree.columns(node);
    work[static_cast<std::size_t>(node)] += c * c * (tree.rows(node) - 2.0 * c / 3.0);
  }
}

void Plan::placeEntries(const std::vector<std::int32_t>& first,
                        const std::vector<std::int32_t>& index) {
  const auto each = [&](const auto& take) {
    for (std::int32_t column = 0; column < tree.n; ++column) {
      const std::int32_t c = tree.inverse[static_cast<std::size_t>(column)];
      for (std::int32_t e = first[static_cast<std::size_t>(column)];
           e < first[static_cast<std::size_t>(column) + 1]; ++e) {
        const std::int32_t r =
            tree.inverse[static_cast<std::size_t>(index[static_cast<std::size_t>(e)])];
        take(e, std::min(r, c), std::max(r, c));
      }
    }
  };
  firstEntry.assign(static_cast<std::size_t>(tree.nodeCount) + 1, 0);
  each([&](std::int32_t, std::int32_t c, std::int32_t) {
    ++firstEntry[static_cast<std::size_t>(tree.nodeOf[static_cast<std::size_t>(c)]) + 1];
  });
  std::partial_sum(firstEntry.begin(), firstEntry.end(), firstEntry.begin());
  entry.resize(index.size());
  place.resize(index.size());
  std::vector<std::int32_t> next(firstEntry.begin(), firstEntry.end() - 1);
  each([&](std::int32_t e, std::int32_t c, std::int32_t r) {
    const std::int32_t node = tree.nodeOf[static_cast<std::size_t>(c)];
    const std::int32_t* s = tree.s + tree.pi[node];
    const auto row = static_cast<std::int32_t>(std::lower_bound(s, s + tree.rows(node), r) - s);
    const auto k = static_cast<std::size_t>(next[static_cast<std::size_t>(node)]++);
    entry[k] = e;
    place[k] = (c - tree.super[node]) * tree.rows(node) + row;
  });
}

// The tree is cut where what hangs below is little enough for one thread.
void Plan::share() {
  const auto nodes = static_cast<std::size_t>(tree.nodeCount);
  std::vector<double> below = work;
  std::vector<std::int32_t> lowest(nodes);
  std::iota(lowest.begin(), lowest.end(), 0);
  for (std::size_t node = 0; node < nodes; ++node) {
    if (tree.parent[node] < 0) continue;
    const auto up = static_cast<std::size_t>(tree.parent[node]);
    below[up] += below[node];
    lowest[up] = std::min(lowest[up], lowest[node]);
  }
  const double most = kLargestSubtree * std::accumulate(work.begin(), work.end(), 0.0);
  for (std::size_t node = 0; node < nodes; ++node) {
    if (below[node] > most) {
      top.push_back(static_cast<std::int32_t>(node));
    } else if (tree.parent[node] < 0 || below[static_cast<std::size_t>(tree.parent[node])] > most) {
      subtree.emplace_back(lowest[node], static_cast<std::int32_t>(node) + 1);
    }
  }
  std::ranges::stable_sort(subtree, std::greater(), [&](const auto& nodesOf) {
    return below[static_cast<std::size_t>(nodesOf.second) - 1];
  });
}

}  // namespace

struct SingleCholesky::Impl {
  std::shared_ptr<const SymbolicCholesky::Impl> symbolic;
  std::shared_ptr<const Plan> plan;
  std::shared_ptr<const SingleCholesky> before;  // whose panels are shared
  std::unique_ptr<float[]> own;
  std::size_t ownCount = 0;
  std::vector<const float*> panel;
  std::vector<float*> made;  // by node; null: of `before`
  std::atomic<bool> ok{true};
  double share = 1.0;

  // What a thread works in
  struct Work {
    std::vector<std::int32_t> placeOf;  // in the panel at hand, by row
    std::vector<float> product;
  };

  void make(const std::vector<double>& values, const std::function<bool()>& stop);
  void begin(std::int32_t node, const std::vector<double>& values);
  void takeOff(std::int32_t node, std::int32_t beginRow, std::int32_t endRow, Work& work) const;
  [[nodiscard]] bool eliminate(std::int32_t node, bool together) const;
};

// K's own entries
void SingleCholesky::Impl::begin(std::int32_t node, const std::vector<double>& values) {
  const auto k = static_cast<std::size_t>(node);
  const Supernodes& t = plan->tree;
  std::fill_n(made[k], static_cast<std::ptrdiff_t>(t.rows(node)) * t.columns(node), 0.0F);
  for (auto i = static_cast<std::size_t>(plan->firstEntry[k]);
       i < static_cast<std::size_t>(plan->firstEntry[k + 1]); ++i)
    made[k][plan->place[i]] = static_cast<float>(values[static_cast<std::size_t>(plan->entry[i])]);
}

// Rows [beginRow, endRow) of the panel: what nodes below it take off.
void SingleCholesky::Impl::takeOff(std::int32_t node, std::int32_t beginRow, std::int32_t endRow,
                                   Work& work) const {
  const auto k = static_cast<std::size_t>(node);
  const Supernodes& t = plan->tree;
  const std::int32_t rows = t.rows(node);
  const std::int32_t* s = t.s + t.pi[node];
  if (work.placeOf.empty()) work.placeOf.resize(static_cast<std::size_t>(t.n));
  for (std::int32_t i = beginRow; i < endRow; ++i) work.placeOf[static_cast<std::size_t>(s[i])] = i;
  const std::int32_t afterRow = endRow < rows ? s[endRow] : t.n;
  for (std::int32_t u = plan->firstUpdate[k]; u < plan->firstUpdate[k + 1]; ++u) {
    const Update& update = plan->update[static_cast<std::size_t>(u)];
    const std::int32_t* below = t.s + t.pi[update.from];
    const std::int32_t ld = t.rows(update.from);
    const auto from = static_cast<std::int32_t>(
        std::lower_bound(below + update.begin, below + ld, s[beginRow]) - below);
    const auto to =
        static_cast<std::int32_t>(std::lower_bound(below + from, below + ld, afterRow) - below);
    const int m = to - from;
    const int n = update.end - update.begin;
    if (m == 0) continue;
    const std::size_t size = static_cast<std::size_t>(m) * static_cast<std::size_t>(n);
    if (work.product.size() < size) work.product.resize(size);
    const float* L = panel[static_cast<std::size_t>(update.from)];
    cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, m, n, t.columns(update.from), 1.0F,
                L + from, ld, L + update.begin, ld, 0.0F, work.product.data(), m);
    const float* product = work.product.data();
    for (int j = 0; j < n; ++j, product += m) {
      float* column =
          made[k] + static_cast<std::ptrdiff_t>(below[update.begin + j] - t.super[node]) * rows;
      // Above the diagonal nothing is kept
      for (int i = std::max(0, update.begin + j - from); i < m; ++i)
        column[work.placeOf[static_cast<std::size_t>(below[from + i])]] -= product[i];
    }
  }
}

// The panel's own columns. False at a pivot that is not positive.
bool SingleCholesky::Impl::eliminate(std::int32_t node, bool together) const {
  const Supernodes& t = plan->tree;
  float* L = made[static_cast<std::size_t>(node)];
  const int rows = t.rows(node);
  const int columns = t.columns(node);
  const int width = together ? kColumns : columns;
  for (int c = 0; c < columns; c += width) {
    const int w = std::min(width, columns - c);
    float* diagonal = L + static_cast<std::ptrdiff_t>(c) * rows + c;
    const auto slab = [&](int from, int to) {
      if (to <= from) return;
      float* block = L + static_cast<std::ptrdiff_t>(c) * rows + from;
      if (c > 0)
        cblas_sgemm(CblasColMajor, CblasNoTrans, CblasTrans, to - from, w, c, -1.0F, L + from, rows,
                    L + c, rows, 1.0F, block, rows);
      cblas_strsm(CblasColMajor, CblasRight, CblasLower, CblasTrans, CblasNonUnit, to - from, w,
                  1.0F, diagonal, rows, block, rows);
    };
    if (c > 0)
      cblas_ssyrk(CblasColMajor, CblasLower, CblasNoTrans, w, c, -1.0F, L + c, rows, 1.0F, diagonal,
                  rows);
    int info = 0;
    spotrf_("L", &w, diagonal, &rows, &info);
    if (info != 0) return false;
    const int rest = rows - c - w;
    if (!together) {
      slab(c + w, rows);
    } else {
      parallelFor(
          kSlabs,
          [&](std::int64_t i) {
            slab(c + w + static_cast<int>(rest * i / kSlabs),
                 c + w + static_cast<int>(rest * (i + 1) / kSlabs));
          },
          1);
    }
  }
  return true;
}

void SingleCholesky::Impl::make(const std::vector<double>& values,
                                const std::function<bool()>& stop) {
  const BlasThreads blas(1);
  const Supernodes& t = plan->tree;
  const auto given = [&] { return !ok || (stop && stop()); };
  parallelFor(
      std::ssize(plan->subtree),
      [&](std::int64_t i) {
        if (given()) {
          ok = false;
          return;
        }
        Work work;
        for (auto node = plan->subtree[static_cast<std::size_t>(i)].first;
             node < plan->subtree[static_cast<std::size_t>(i)].second; ++node) {
          if (made[static_cast<std::size_t>(node)] == nullptr) continue;
          begin(node, values);
          takeOff(node, 0, t.rows(node), work);
          if (!eliminate(node, false)) {
            ok = false;
            return;
          }
        }
      },
      1);
  std::vector<Work> work(kSlabs);
  for (const std::int32_t node : plan->top) {
    if (made[static_cast<std::size_t>(node)] == nullptr) continue;
    if (given()) {
      ok = false;
      return;
    }
    begin(node, values);
    // Upper rows have less in them: their columns end at the diagonal
    const std::int32_t rows = t.rows(node);
    parallelFor(
        kSlabs,
        [&](std::int64_t i) {
          takeOff(node, static_cast<std::int32_t>(rows * i / kSlabs),
                  static_cast<std::int32_t>(rows * (i + 1) / kSlabs),
                  work[static_cast<std::size_t>(i)]);
        },
        1);
    if (!eliminate(node, true)) {
      ok = false;
      return;
    }
  }
}

SingleCholesky::SingleCholesky(const SymbolicCholesky& symbolic, const std::vector<double>& values,
                               const std::function<bool()>& stop)
    : impl_(std::make_unique<Impl>()) {
  Impl& I = *impl_;
  I.symbolic = symbolic.impl_;
  EC_REQUIRE_EQ(values.size(), I.symbolic->index.size());
  I.plan = std::make_shared<const Plan>(*I.symbolic->L, I.symbolic->first, I.symbolic->index);
  const Supernodes& t = I.plan->tree;
  I.ownCount = I.symbolic->L->xsize;
  I.own = std::make_unique_for_overwrite<float[]>(I.ownCount);
  for (std::int32_t node = 0; node < t.nodeCount; ++node) {
    I.made.push_back(I.own.get() + t.px[node]);
    I.panel.push_back(I.made.back());
  }
  I.make(values, stop);
}

SingleCholesky::SingleCholesky(const std::shared_ptr<const SingleCholesky>& before,
                               const std::vector<double>& values,
                               std::span<const std::int32_t> changed,
                               const std::function<bool()>& stop)
    : impl_(std::make_unique<Impl>()) {
  EC_REQUIRE(before != nullptr && before->ok());
  Impl& I = *impl_;
  I.symbolic = before->impl_->symbolic;
  I.plan = before->impl_->plan;
  I.before = before;
  EC_REQUIRE_EQ(values.size(), I.symbolic->index.size());
  const Supernodes& t = I.plan->tree;
  I.panel = before->impl_->panel;
  I.made.assign(I.panel.size(), nullptr);
  const std::vector<std::uint8_t> on = before->ancestors(changed);
  for (std::size_t node = 0; node < on.size(); ++node) {
    if (on[node] != 0) I.ownCount += static_cast<std::size_t>(t.px[node + 1] - t.px[node]);
  }
  I.share = before->shareOf(changed);
  I.own = std::make_unique_for_overwrite<float[]>(I.ownCount);
  float* next = I.own.get();
  for (std::size_t node = 0; node < on.size(); ++node) {
    if (on[node] == 0) continue;
    I.made[node] = next;
    I.panel[node] = next;
    next += t.px[node + 1] - t.px[node];
  }
  I.make(values, stop);
}
SingleCholesky::~SingleCholesky() = default;

std::size_t SingleCholesky::bytes() const { return impl_->ownCount * sizeof(float); }
const std::shared_ptr<const SingleCholesky>& SingleCholesky::before() const {
  return impl_->before;
}

// Nodes on the way from rows to the root.
std::vector<std::uint8_t> SingleCholesky::ancestors(std::span<const std::int32_t> changed) const {
  const Supernodes& t = impl_->plan->tree;
  std::vector<std::uint8_t> on(impl_->panel.size(), 0);
  for (const std::int32_t r : changed) {
    for (std::int32_t node =
             t.nodeOf[static_cast<std::size_t>(t.inverse[static_cast<std::size_t>(r)])];
         node >= 0 && on[static_cast<std::size_t>(node)] == 0;
         node = t.parent[static_cast<std::size_t>(node)])
      on[static_cast<std::size_t>(node)] = 1;
  }
  return on;
}

double SingleCholesky::shareOf(std::span<const std::int32_t> changed) const {
  const std::vector<std::uint8_t> on = ancestors(changed);
  const std::vector<double>& work = impl_->plan->work;
  double some = 0.0;
  double all = 0.0;
  for (std::size_t node = 0; node < on.size(); ++node) {
    all += work[node];
    if (on[node] != 0) some += work[node];
  }
  return some / all;
}

bool SingleCholesky::ok() const { return impl_->ok; }
double SingleCholesky::shareMade() const { return impl_->share; }
const cholmod_factor_struct& SingleCholesky::symbolicFactor() const { return *impl_->symbolic->L; }
const std::vector<const float*>& SingleCholesky::panels() const { return impl_->panel; }

}  // namespace ecorche::mesh
