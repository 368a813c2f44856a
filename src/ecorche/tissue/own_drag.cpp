#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/own_drag.h>
#include <ecorche/tissue/sample_targets.h>
#include <ecorche/tissue/spread_tensors.h>

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>

// Letters: K the matrix of the own equations, A tensors of the medium, x the field.

namespace ecorche::tissue {

namespace {

using Matrix = Eigen::SparseMatrix<float, Eigen::ColMajor, std::int32_t>;
// Its diagonal will do: an incomplete factor takes a third of the iterations, but longer to make
using Solver = Eigen::ConjugateGradient<Matrix, Eigen::Lower | Eigen::Upper,
                                        Eigen::DiagonalPreconditioner<float>>;

// Around what is more than negligible, for a frame to move into
constexpr int kRoomRings = 1;
// A hand that moved fast has left them behind: a frame is solved again in so many more of them, and
// twice as many each time after that
constexpr int kMoreRings = 2;
constexpr int kMostRings = 64;
// At the rim, over what is negligible
constexpr double kTooMuchAtRim = 2.0;
// Spreads follow as closely as fields of so many times the largest value would: the medium is a
// quotient of them
constexpr double kSpreadScale = 2.0;
// Of what is spread, what may be nothing but what a few unknowns along the curve leave over
constexpr double kLeftOver = 1e-3;

}  // namespace

struct OwnDrag::Impl {
  const domain::Domain& domain;
  std::shared_ptr<const DragGround> shared;
  std::shared_ptr<const OwnGround> own;
  CurveTissue tissue;
  TissueId id;
  std::vector<CoreSample> staying;
  RawRow raw;
  double maxValue = 0.0;
  OwnDragOptions how;

  std::vector<std::int32_t> regionRow;  // #rows of the shared equations, of the own region; −1
  std::vector<std::int32_t> settled;    // rows where the settled field is not negligible, ascending
  std::vector<std::int32_t> last;       // the same of the last frame
  std::vector<float> x;                 // #rows, of the last frame

  // Of one frame. All are of rows, tets and entries of the whole domain, and empty between frames
  std::vector<std::int32_t> seenAt;   // #rows: place among rows that are corners of a tet; −1
  std::vector<std::int32_t> placeAt;  // #rows: place among rows that are solved for; −1
  std::vector<std::int32_t> tetAt;    // #T: place among tets; −1
  std::vector<double> K;              // on the pattern

  struct Patch {
    std::vector<std::int32_t> row;                    // ascending
    std::vector<std::int32_t> tets;                   // those with a row among their corners
    std::vector<std::int32_t> seen;                   // their corners
    std::vector<std::array<std::int32_t, 4>> corner;  // of each tet, among those seen; −1
  };

  Impl(const domain::Domain& d, CurveTissue t) : domain(d), tissue(std::move(t)) {}

  [[nodiscard]] const mesh::StiffnessPattern& pattern() const { return *shared->pattern; }
  [[nodiscard]] std::int32_t field() const {
    return static_cast<std::int32_t>(id.value - kFat.value);
  }
  [[nodiscard]] std::int32_t row(std::int32_t tet, int k) const {
    return pattern().row[static_cast<std::size_t>(domain.mesh.T(tet, k))];
  }
  void settledSpread(std::int32_t row, double* out) const;
  void touch(const std::vector<CoreSample>& samples, std::vector<std::int32_t>& rows) const;
  Patch open(std::vector<std::int32_t> rows);
  void close(const Patch& patch);
  [[nodiscard]] std::vector<Eigen::Matrix3d> medium(const Patch& patch,
                                                    std::span<const SpreadChange> spread) const;
  void solve(const Patch& patch, const PiecedRows& now, std::span<const SpreadChange> spread);
  [[nodiscard]] std::vector<std::int32_t> overflowing(const Patch& patch) const;
};

OwnDrag::~OwnDrag() = default;
OwnDrag::OwnDrag(OwnDrag&&) noexcept = default;
OwnDrag& OwnDrag::operator=(OwnDrag&&) noexcept = default;

OwnDrag::OwnDrag(const domain::Domain& domain, std::shared_ptr<const DragGround> shared,
                 std::shared_ptr<const OwnGround> own, CurveTissue tissue, TissueId id,
                 std::vector<CoreSample> staying, RawRow raw, double maxValue, OwnDragOptions how)
    : impl_(std::make_unique<Impl>(domain, std::move(tissue))) {
  Impl& I = *impl_;
  I.shared = std::move(shared);
  I.own = std::move(own);
  I.id = id;
  I.staying = std::move(staying);
  I.raw = std::move(raw);
  I.maxValue = maxValue;
  I.how = how;
  const auto rows = static_cast<std::size_t>(I.pattern().rowCount());
  I.regionRow.assign(rows, -1);
  for (std::size_t r = 0; r < I.own->region->row.size(); ++r)
    I.regionRow[static_cast<std::size_t>(I.own->region->row[r])] = static_cast<std::int32_t>(r);
  I.x.assign(rows, 0.0F);
  const double least = how.negligible * maxValue;
  for (const std::int32_t r : I.own->region->row) {
    const double value = I.raw(I.pattern().vertex[static_cast<std::size_t>(r)])[I.field()];
    if (std::abs(value) <= least) continue;
    I.settled.push_back(r);
    I.x[static_cast<std::size_t>(r)] = static_cast<float>(value);
  }
  std::ranges::sort(I.settled);
  I.last = I.settled;
  I.seenAt.assign(rows, -1);
  I.placeAt.assign(rows, -1);
  I.tetAt.assign(static_cast<std::size_t>(domain.mesh.T.rows()), -1);
  I.K.assign(I.pattern().entryCount(), 0.0);
}

std::int32_t OwnDrag::field() const { return impl_->field(); }

void OwnDrag::setCurve(std::int32_t curve, const mesh::Spline& spline) {
  impl_->tissue.curves[static_cast<std::size_t>(curve)].spline = spline;
}

DragSystem::Targets OwnDrag::spreadTargets(const PiecedRows& rows) const {
  const Impl& I = *impl_;
  DragSystem::Targets out = DragSystem::Targets::Zero(std::ssize(rows.samples), kSpread);
  std::vector<std::size_t> of;
  for (std::size_t i = 0; i < rows.samples.size(); ++i) {
    if (rows.samples[i].tissue == I.id) of.push_back(i);
  }
  std::ranges::stable_sort(of, {}, [&](std::size_t i) { return rows.samples[i].curve; });
  std::vector<CoreSample> own;
  for (const std::size_t i : of) own.push_back(rows.samples[i]);
  const std::vector<TensorEntries> entries = tensorEntries(I.domain, I.tissue, own);
  for (std::size_t k = 0; k < of.size(); ++k)
    out.row(static_cast<Eigen::Index>(of[k])) =
        kSpreadScale * I.maxValue *
        Eigen::Map<const Eigen::RowVectorXd>(entries[k].data(), kSpread);
  return out;
}

void OwnDrag::Impl::settledSpread(std::int32_t r, double* out) const {
  const std::int32_t here = regionRow[static_cast<std::size_t>(r)];
  for (int k = 0; k < kSpread; ++k)
    out[k] = here < 0 ? 0.0 : kSpreadScale * maxValue * static_cast<double>(own->spread(here, k));
}

void OwnDrag::settledSpread(std::int32_t vertex, double* out) const {
  const std::int32_t r = impl_->pattern().row[static_cast<std::size_t>(vertex)];
  if (r >= 0) {
    impl_->settledSpread(r, out);
  } else {
    std::fill_n(out, kSpread, 0.0);
  }
}

// Rows that this tissue's samples pull on
void OwnDrag::Impl::touch(const std::vector<CoreSample>& samples,
                          std::vector<std::int32_t>& rows) const {
  for (const CoreSample& s : samples) {
    if (s.tissue != id) continue;
    for (int k = 0; k < 4; ++k) {
      if (const std::int32_t r = row(s.tet, k); r >= 0) rows.push_back(r);
    }
  }
}

OwnDrag::Impl::Patch OwnDrag::Impl::open(std::vector<std::int32_t> rows) {
  Patch out;
  out.row = std::move(rows);
  for (std::size_t i = 0; i < out.row.size(); ++i)
    placeAt[static_cast<std::size_t>(out.row[i])] = static_cast<std::int32_t>(i);
  const mesh::VertexTets& around = pattern().vertexTets;
  for (const std::int32_t r : out.row) {
    const auto v = static_cast<std::size_t>(pattern().vertex[static_cast<std::size_t>(r)]);
    for (auto i = static_cast<std::size_t>(around.first[v]);
         i < static_cast<std::size_t>(around.first[v + 1]); ++i) {
      const std::int32_t t = around.tet[i];
      if (tetAt[static_cast<std::size_t>(t)] >= 0) continue;
      tetAt[static_cast<std::size_t>(t)] = static_cast<std::int32_t>(out.tets.size());
      out.tets.push_back(t);
      std::array<std::int32_t, 4>& corners = out.corner.emplace_back();
      for (int k = 0; k < 4; ++k) {
        const std::int32_t c = row(t, k);
        corners[static_cast<std::size_t>(k)] = c;
        if (c < 0) continue;
        std::int32_t& at = seenAt[static_cast<std::size_t>(c)];
        if (at < 0) {
          at = static_cast<std::int32_t>(out.seen.size());
          out.seen.push_back(c);
        }
        corners[static_cast<std::size_t>(k)] = at;
      }
    }
  }
  return out;
}

void OwnDrag::Impl::close(const Patch& patch) {
  for (const std::int32_t t : patch.tets) {
    tetAt[static_cast<std::size_t>(t)] = -1;
    for (const std::int32_t slot : pattern().edgeSlot[static_cast<std::size_t>(t)]) {
      if (slot >= 0) K[static_cast<std::size_t>(slot)] = 0.0;
    }
  }
  for (const std::int32_t r : patch.seen) {
    seenAt[static_cast<std::size_t>(r)] = -1;
    K[static_cast<std::size_t>(pattern().diagonal(r))] = 0.0;
  }
  for (const std::int32_t r : patch.row) placeAt[static_cast<std::size_t>(r)] = -1;
}

// Tensors of a patch's tets
std::vector<Eigen::Matrix3d> OwnDrag::Impl::medium(const Patch& patch,
                                                   std::span<const SpreadChange> spread) const {
  std::vector<TensorEntries> here(patch.seen.size());
  for (std::size_t i = 0; i < here.size(); ++i) settledSpread(patch.seen[i], here[i].data());
  for (const SpreadChange& part : spread) {
    for (std::size_t i = 0; i < part.row.size(); ++i) {
      const std::int32_t at = seenAt[static_cast<std::size_t>(part.row[i])];
      if (at < 0) continue;
      for (std::size_t k = 0; k < kSpread; ++k) {
        if (part.column[k] >= 0)
          here[static_cast<std::size_t>(at)][k] +=
              static_cast<double>((*part.change)(static_cast<Eigen::Index>(i), part.column[k]));
      }
    }
  }
  const SpreadTensor tensor(tissue.anisotropy, kLeftOver * kSpreadScale * maxValue);
  std::vector<Eigen::Matrix3d> atRow(here.size());
  parallelFor(std::ssize(here), [&](std::int64_t i) {
    atRow[static_cast<std::size_t>(i)] = tensor(here[static_cast<std::size_t>(i)]);
  });
  std::vector<Eigen::Matrix3d> A(patch.tets.size());
  parallelFor(std::ssize(A), [&](std::int64_t i) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    int count = 0;
    for (const std::int32_t at : patch.corner[static_cast<std::size_t>(i)]) {
      if (at < 0) continue;
      sum += atRow[static_cast<std::size_t>(at)];
      ++count;
    }
    A[static_cast<std::size_t>(i)] = sum / count;
  });
  return A;
}

// x on a patch; nothing around it.
void OwnDrag::Impl::solve(const Patch& patch, const PiecedRows& now,
                          std::span<const SpreadChange> spread) {
  if (patch.row.empty()) return;  // nothing of it is in the domain
  const std::vector<Eigen::Matrix3d> A = medium(patch, spread);
  std::vector<std::array<double, 6>> stiffness(A.size());
  parallelFor(std::ssize(A), [&](std::int64_t i) {
    const auto k = static_cast<std::size_t>(i);
    stiffness[k] = mesh::edgeStiffness(domain.mesh, patch.tets[k], A[k]);
  });
  std::vector<double> diagonal(patch.seen.size(), 0.0);
  for (std::size_t i = 0; i < A.size(); ++i) {
    const auto& slots = pattern().edgeSlot[static_cast<std::size_t>(patch.tets[i])];
    for (std::size_t e = 0; e < 6; ++e) {
      const double k = stiffness[i][e];
      if (slots[e] >= 0) K[static_cast<std::size_t>(slots[e])] += k;
      for (const int end : mesh::kTetEdge[e]) {
        const std::int32_t at = patch.corner[i][static_cast<std::size_t>(end)];
        if (at >= 0) diagonal[static_cast<std::size_t>(at)] -= k;
      }
    }
  }
  for (std::size_t i = 0; i < diagonal.size(); ++i)
    K[static_cast<std::size_t>(pattern().diagonal(patch.seen[i]))] = diagonal[i];

  // Rows of curves, and what those of this tissue ask for
  Eigen::VectorXf b = Eigen::VectorXf::Zero(std::ssize(patch.row));
  std::vector<CoreSample> weighed;
  const auto weigh = [&](const CoreSample& s, double target) {
    const std::int32_t at = tetAt[static_cast<std::size_t>(s.tet)];
    if (at < 0) return;
    weighed.push_back(s);
    weighed.back().weight = weightIn(A[static_cast<std::size_t>(at)], s);
    if (s.tissue != id) return;
    for (int k = 0; k < 4; ++k) {
      const std::int32_t r = row(s.tet, k);
      if (r < 0 || placeAt[static_cast<std::size_t>(r)] < 0) continue;
      b[placeAt[static_cast<std::size_t>(r)]] +=
          static_cast<float>(weighed.back().weight * s.barycentric[k] * target);
    }
  };
  for (const CoreSample& s : staying) weigh(s, s.tissue == id ? sampleTarget(tissue, s) : 0.0);
  for (const RowPiece& piece : now.pieces) {
    for (std::int32_t i = piece.first; i < piece.first + piece.count; ++i)
      weigh(now.samples[static_cast<std::size_t>(i)], piece.target);
  }
  addRows(domain.mesh, pattern(), weighed, 1.0, K);

  // To a matrix of its own
  const mesh::NeighbourRows& neighbours = *shared->rows;
  std::vector<std::int32_t> inner;
  std::vector<float> value;
  inner.reserve(16 * patch.row.size());
  value.reserve(16 * patch.row.size());
  std::vector<std::pair<std::int32_t, std::int32_t>> column;
  std::vector<std::int32_t> outer{0};
  for (std::size_t i = 0; i < patch.row.size(); ++i) {
    const auto r = static_cast<std::size_t>(patch.row[i]);
    column.assign(1, {static_cast<std::int32_t>(i), pattern().diagonal(patch.row[i])});
    for (auto e = static_cast<std::size_t>(neighbours.first[r]);
         e < static_cast<std::size_t>(neighbours.first[r + 1]); ++e) {
      const std::int32_t at = placeAt[static_cast<std::size_t>(neighbours.neighbour[e])];
      if (at >= 0) column.emplace_back(at, neighbours.slot[e]);
    }
    std::ranges::sort(column);
    for (const auto& [at, slot] : column) {
      inner.push_back(at);
      value.push_back(static_cast<float>(K[static_cast<std::size_t>(slot)]));
    }
    outer.push_back(static_cast<std::int32_t>(inner.size()));
  }
  const Matrix small =
      Eigen::Map<const Matrix>(std::ssize(patch.row), std::ssize(patch.row), std::ssize(inner),
                               outer.data(), inner.data(), value.data());
  Eigen::VectorXf guess(std::ssize(patch.row));
  for (std::size_t i = 0; i < patch.row.size(); ++i)
    guess[static_cast<Eigen::Index>(i)] = x[static_cast<std::size_t>(patch.row[i])];
  Solver solver;
  solver.setTolerance(static_cast<float>(how.residual));
  solver.setMaxIterations(how.iterations);
  solver.compute(small);
  const Eigen::VectorXf found = solver.solveWithGuess(b, guess);
  for (std::size_t i = 0; i < patch.row.size(); ++i)
    x[static_cast<std::size_t>(patch.row[i])] = found[static_cast<Eigen::Index>(i)];
}

// Rows of a patch's rim where the field is more than it should be there
std::vector<std::int32_t> OwnDrag::Impl::overflowing(const Patch& patch) const {
  const auto most = static_cast<float>(kTooMuchAtRim * how.negligible * maxValue);
  std::vector<std::int32_t> out;
  const mesh::NeighbourRows& neighbours = *shared->rows;
  for (const std::int32_t row : patch.row) {
    const auto r = static_cast<std::size_t>(row);
    if (std::abs(x[r]) <= most) continue;
    for (auto e = static_cast<std::size_t>(neighbours.first[r]);
         e < static_cast<std::size_t>(neighbours.first[r + 1]); ++e) {
      if (placeAt[static_cast<std::size_t>(neighbours.neighbour[e])] >= 0) continue;
      out.push_back(row);
      break;
    }
  }
  return out;
}

DragSystem::Part OwnDrag::move(const PiecedRows& now, std::span<const SpreadChange> spread) {
  Impl& I = *impl_;
  const auto least = static_cast<float>(I.how.negligible * I.maxValue);
  std::vector<std::int32_t> start = I.last;
  I.touch(now.samples, start);
  I.touch(I.staying, start);
  Impl::Patch patch = I.open(rowsAround(*I.shared, start, kRoomRings));
  I.solve(patch, now, spread);
  for (int rings = kMoreRings; rings <= kMostRings; rings *= 2) {
    const std::vector<std::int32_t> over = I.overflowing(patch);
    if (over.empty()) break;
    std::vector<std::int32_t> more = rowsAround(*I.shared, over, rings);
    more.insert(more.end(), patch.row.begin(), patch.row.end());
    std::ranges::sort(more);
    more.erase(std::ranges::unique(more).begin(), more.end());
    I.close(patch);
    patch = I.open(std::move(more));
    I.solve(patch, now, spread);
  }

  DragSystem::Part out;
  out.fields = {I.field()};
  for (const std::int32_t r : I.overflowing(patch))
    out.lastStep =
        std::max(out.lastStep, std::abs(static_cast<double>(I.x[static_cast<std::size_t>(r)])));
  I.close(patch);
  I.last.clear();
  for (const std::int32_t r : patch.row) {
    float& value = I.x[static_cast<std::size_t>(r)];
    if (std::abs(value) > least) {
      I.last.push_back(r);
    } else {
      value = 0.0F;
    }
  }
  std::ranges::set_union(I.last, I.settled, std::back_inserter(out.row));
  out.change.resize(std::ssize(out.row), 1);
  for (std::size_t i = 0; i < out.row.size(); ++i) {
    const std::int32_t r = out.row[i];
    const double before = I.raw(I.pattern().vertex[static_cast<std::size_t>(r)])[I.field()];
    out.change(static_cast<Eigen::Index>(i), 0) =
        I.x[static_cast<std::size_t>(r)] - static_cast<float>(before);
  }
  return out;
}

}  // namespace ecorche::tissue
