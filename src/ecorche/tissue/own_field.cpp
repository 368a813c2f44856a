#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/anisotropy.h>
#include <ecorche/tissue/own_field.h>
#include <ecorche/tissue/sample_targets.h>
#include <ecorche/tissue/spread_tensors.h>

#include <algorithm>
#include <cmath>

// Letters as in tissue_solver.cpp: K what all share, A tensors, x the field.

namespace ecorche::tissue {

namespace {

// Shares of the field's largest value: what a region keeps, and what may reach its rim
constexpr double kKept = 1e-11;
constexpr double kAtRim = 2e-9;
constexpr int kSpareRings = 2;
// Of the domain: a region of more is no gain
constexpr double kMostOfDomain = 0.9;

// Bᵀ W of one tissue's rows, for what each asks for
Eigen::MatrixXd rightSide(const FieldRegion& region, const std::vector<CoreSample>& own,
                          const Eigen::MatrixXd& worth) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(region.pattern->rowCount(), worth.cols());
  for (std::size_t i = 0; i < own.size(); ++i) {
    for (int k = 0; k < 4; ++k) {
      const auto r = region.pattern->row[static_cast<std::size_t>(region.mesh.T(own[i].tet, k))];
      if (r >= 0)
        out.row(r) +=
            own[i].weight * own[i].barycentric[k] * worth.row(static_cast<Eigen::Index>(i));
    }
  }
  return out;
}

std::shared_ptr<const OwnGround> groundOf(std::shared_ptr<const FieldRegion> region,
                                          std::shared_ptr<const mesh::Cholesky> factor,
                                          std::vector<double> K,
                                          std::vector<OwnGround::Tensor> medium,
                                          OwnGround::Spread spread, std::vector<CoreSample> own) {
  auto out = std::make_shared<OwnGround>();
  out->ground = std::make_shared<const DragGround>(region->pattern, region->symbolic,
                                                   mesh::TreeSolver<float>(std::move(factor)),
                                                   std::move(K), region->neighbours);
  out->region = std::move(region);
  out->medium = std::move(medium);
  out->spread = std::move(spread);
  out->own = std::move(own);
  return out;
}

}  // namespace

std::vector<CoreSample> OwnGround::rowsOf(const std::vector<CoreSample>& samples) const {
  std::vector<CoreSample> out = region->within(samples);
  for (CoreSample& s : out) {
    const Tensor& m = medium[static_cast<std::size_t>(s.tet)];
    Eigen::Matrix3d A;
    A << m[0], m[3], m[4],  //
        m[3], m[1], m[5],   //
        m[4], m[5], m[2];
    s.weight *= crossCapacity(A, s.tangent);
  }
  return out;
}

PiecedRows OwnGround::rowsOf(const PiecedRows& rows) const {
  PiecedRows out;
  std::size_t p = 0;
  for (const std::int32_t end : rows.curveEnd) {
    for (; p < static_cast<std::size_t>(end); ++p) {
      RowPiece piece = rows.pieces[p];
      const auto begin = rows.samples.begin() + piece.first;
      const std::vector<CoreSample> here = rowsOf(std::vector(begin, begin + piece.count));
      if (here.empty()) continue;
      piece.first = static_cast<std::int32_t>(out.samples.size());
      piece.count = static_cast<std::int32_t>(here.size());
      out.samples.insert(out.samples.end(), here.begin(), here.end());
      out.pieces.push_back(piece);
    }
    out.curveEnd.push_back(static_cast<std::int32_t>(out.pieces.size()));
  }
  return out;
}

Eigen::MatrixXd OwnGround::solve(const Eigen::MatrixXd& targets) const {
  EC_REQUIRE_EQ(targets.rows(), std::ssize(own));
  Eigen::MatrixXd X = rightSide(*region, own, targets);
  mesh::Cholesky(*region->symbolic, ground->K, 1).solveInPlace(X);
  return X;
}

struct OwnField::Impl {
  // Everything of one region, and what it was solved for
  struct State {
    std::shared_ptr<const FieldRegion> region;
    std::vector<double> sharedK;
    std::vector<TensorEntries> entries;
    std::vector<double> targets;
    std::shared_ptr<const OwnGround> ground;
    Eigen::VectorXd x;
  };
  State state;

  // Rows as a region sees them
  struct Wanted {
    std::vector<CoreSample> samples;  // of all tissues
    std::vector<CoreSample> own;
    std::vector<double> targets;  // of own
    std::vector<TensorEntries> entries;
    double largest = 0.0;
    bool covered = true;  // no row of its own reaches out
  };
  static Wanted wantedIn(const FieldRegion& region, const TissueSolver& solver,
                         const CoreSamples& cores, const CurveTissue& tissue, TissueId id);
  static Outcome solveIn(State& state, const SharedEquations& all, const CurveTissue& tissue,
                         const Wanted& wanted, const std::function<bool()>& stop);
  static Outcome shrink(State& state, const TissueSolver& solver, double largest,
                        const std::function<bool()>& stop);
};

std::shared_ptr<const FieldRegion> OwnField::wholeOf(const TissueSolver& solver) {
  const auto n = static_cast<std::size_t>(solver.pattern().rowCount());
  return std::make_shared<const FieldRegion>(solver, std::vector<std::uint8_t>(n, 1));
}

OwnField::OwnField() : impl_(std::make_unique<Impl>()) {}
OwnField::OwnField(OwnField&&) noexcept = default;
OwnField& OwnField::operator=(OwnField&&) noexcept = default;
OwnField::~OwnField() = default;
const std::shared_ptr<const OwnGround>& OwnField::ground() const { return impl_->state.ground; }
const Eigen::VectorXd& OwnField::values() const { return impl_->state.x; }

OwnField::Impl::Wanted OwnField::Impl::wantedIn(const FieldRegion& region,
                                                const TissueSolver& solver,
                                                const CoreSamples& cores, const CurveTissue& tissue,
                                                TissueId id) {
  Wanted out;
  std::vector<CoreSample> own;
  std::ranges::copy_if(cores.samples, std::back_inserter(own),
                       [&](const CoreSample& s) { return s.tissue == id; });
  out.samples = region.within(cores.samples);
  out.own = region.within(own);
  out.largest = tissue.largestValue();
  out.covered = out.own.size() == own.size();
  for (const CoreSample& s : out.own) {
    out.targets.push_back(sampleTarget(tissue, s));
    for (int k = 0; k < 4; ++k) {
      const auto v = static_cast<std::size_t>(region.mesh.T(s.tet, k));
      const auto everywhere = static_cast<std::size_t>(region.vertex[v]);
      if (region.pattern->row[v] < 0 && solver.pattern().row[everywhere] >= 0) out.covered = false;
    }
  }
  if (out.covered) out.entries = tensorEntries(solver.domain(), tissue, out.own);
  return out;
}

// Brings a state to what is wanted, where that is another thing; the region stays.
OwnField::Outcome OwnField::Impl::solveIn(State& state, const SharedEquations& all,
                                          const CurveTissue& tissue, const Wanted& wanted,
                                          const std::function<bool()>& stop) {
  const FieldRegion& region = *state.region;
  const mesh::StiffnessPattern& pattern = *region.pattern;
  std::vector<double> shared = region.gather(all.K);
  if (state.ground && state.sharedK == shared && state.entries == wanted.entries) {
    if (state.targets == wanted.targets) return Outcome::Done;
    state.x = state.ground->solve(
        Eigen::Map<const Eigen::VectorXd>(wanted.targets.data(), std::ssize(wanted.targets)));
    state.targets = wanted.targets;
    return Outcome::Done;
  }

  // Tensors
  Eigen::MatrixXd Y(std::ssize(wanted.own), 7);
  for (std::size_t i = 0; i < wanted.own.size(); ++i)
    Y.row(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::RowVectorXd>(wanted.entries[i].data(), 7);
  Y = rightSide(region, wanted.own, Y);
  if (region.isWhole()) {
    const mesh::Cholesky& factor = all.factor();
    if (!factor.ok()) return Outcome::Singular;
    factor.solveInPlace(Y);
  } else {
    const mesh::Cholesky factor(*region.symbolic, shared, 1);
    if (!factor.ok()) return Outcome::Singular;
    if (stop()) return Outcome::Stopped;
    factor.solveInPlace(Y);
  }
  if (stop()) return Outcome::Stopped;
  const auto A = tetTensors(region.mesh, pattern, Y, tissue.anisotropy);
  std::vector<double> ownK =
      mesh::assembleStiffness(region.mesh, pattern, mesh::edgeStiffness(region.mesh, A));
  std::vector<CoreSample> weighed = wanted.samples;
  for (CoreSample& s : weighed) s.weight = weightIn(A[static_cast<std::size_t>(s.tet)], s);
  addRows(region.mesh, pattern, weighed, 1.0, ownK);
  if (stop()) return Outcome::Stopped;

  // The field
  const auto factor = std::make_shared<const mesh::Cholesky>(*region.symbolic, ownK, 1);
  if (!factor->ok()) return Outcome::Singular;
  if (stop()) return Outcome::Stopped;
  weighed = wanted.own;
  for (CoreSample& s : weighed) s.weight = weightIn(A[static_cast<std::size_t>(s.tet)], s);
  Eigen::MatrixXd X = rightSide(
      region, weighed,
      Eigen::Map<const Eigen::VectorXd>(wanted.targets.data(), std::ssize(wanted.targets)));
  factor->solveInPlace(X);
  if (stop()) return Outcome::Stopped;
  std::vector<OwnGround::Tensor> medium(A.size());
  parallelFor(std::ssize(A), [&](std::int64_t t) {
    const Eigen::Matrix3f m = A[static_cast<std::size_t>(t)].cast<float>();
    medium[static_cast<std::size_t>(t)] = {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
  });
  state.ground = groundOf(state.region, factor, std::move(ownK), std::move(medium), Y.cast<float>(),
                          std::move(weighed));
  state.sharedK = std::move(shared);
  state.entries = wanted.entries;
  state.targets = wanted.targets;
  state.x = X.col(0);
  return Outcome::Done;
}

// From all of the domain to where the field is something.
OwnField::Outcome OwnField::Impl::shrink(State& state, const TissueSolver& solver, double largest,
                                         const std::function<bool()>& stop) {
  // The whole region's rows are the solver's
  const Eigen::Index n = state.x.size();
  std::vector<std::uint8_t> inside(static_cast<std::size_t>(n), 0);
  for (Eigen::Index r = 0; r < n; ++r)
    inside[static_cast<std::size_t>(r)] = std::abs(state.x[r]) > kKept * largest ? 1 : 0;
  const FieldRegion& whole = *state.region;
  for (const CoreSample& s : state.ground->own) {
    for (int k = 0; k < 4; ++k) {
      const auto r = whole.pattern->row[static_cast<std::size_t>(whole.mesh.T(s.tet, k))];
      if (r >= 0) inside[static_cast<std::size_t>(r)] = 1;
    }
  }
  // Fields fall steeply in places: beside what is kept, rows that are as good as nothing
  for (int ring = 0; ring < kSpareRings; ++ring) {
    const std::vector<std::uint8_t> before = inside;
    for (std::size_t r = 0; r < before.size(); ++r) {
      if (before[r] == 0) continue;
      for (auto e = static_cast<std::size_t>(whole.neighbours->first[r]);
           e < static_cast<std::size_t>(whole.neighbours->first[r + 1]); ++e)
        inside[static_cast<std::size_t>(whole.neighbours->neighbour[e])] = 1;
    }
  }
  if (static_cast<double>(std::ranges::count(inside, 1)) > kMostOfDomain * static_cast<double>(n))
    return Outcome::Done;
  State next;
  next.region = std::make_shared<const FieldRegion>(solver, inside);
  const FieldRegion& region = *next.region;
  if (stop()) return Outcome::Stopped;
  next.sharedK = region.gather(state.sharedK);
  next.entries = std::move(state.entries);
  next.targets = std::move(state.targets);
  next.x = state.x(region.row);
  std::vector<double> K = region.gather(state.ground->ground->K);
  auto factor = std::make_shared<const mesh::Cholesky>(*region.symbolic, K, 1);
  if (!factor->ok()) return Outcome::Singular;
  std::vector<OwnGround::Tensor> medium(static_cast<std::size_t>(region.mesh.T.rows()));
  std::vector<std::int32_t> here(static_cast<std::size_t>(whole.mesh.T.rows()), -1);
  for (std::size_t t = 0; t < region.tet.size(); ++t) {
    if (region.tet[t] < 0) continue;
    here[static_cast<std::size_t>(whole.tet[t])] = region.tet[t];
    medium[static_cast<std::size_t>(region.tet[t])] =
        state.ground->medium[static_cast<std::size_t>(whole.tet[t])];
  }
  std::vector<CoreSample> own = state.ground->own;
  for (CoreSample& s : own) s.tet = here[static_cast<std::size_t>(s.tet)];
  next.ground = groundOf(next.region, std::move(factor), std::move(K), std::move(medium),
                         state.ground->spread(region.row, Eigen::all), std::move(own));
  state = std::move(next);
  return Outcome::Done;
}

OwnField::Outcome OwnField::solve(const TissueSolver& solver, const SharedEquations& shared,
                                  const CoreSamples& cores, const CurveTissue& tissue, TissueId id,
                                  const std::function<bool()>& stop) {
  if (impl_->state.region) {
    Impl::State next = impl_->state;
    const auto wanted = Impl::wantedIn(*next.region, solver, cores, tissue, id);
    if (wanted.covered) {
      if (const Outcome how = Impl::solveIn(next, shared, tissue, wanted, stop);
          how != Outcome::Done)
        return how;
      double atRim = 0.0;
      for (const std::int32_t r : next.region->rim) atRim = std::max(atRim, std::abs(next.x[r]));
      if (atRim <= kAtRim * wanted.largest) {
        impl_->state = std::move(next);
        return Outcome::Done;
      }
    }
  }
  Impl::State next;
  next.region = shared.whole ? shared.whole : wholeOf(solver);
  const auto wanted = Impl::wantedIn(*next.region, solver, cores, tissue, id);
  if (const Outcome how = Impl::solveIn(next, shared, tissue, wanted, stop); how != Outcome::Done)
    return how;
  if (const Outcome how = Impl::shrink(next, solver, wanted.largest, stop); how != Outcome::Done)
    return how;
  impl_->state = std::move(next);
  return Outcome::Done;
}

}  // namespace ecorche::tissue
