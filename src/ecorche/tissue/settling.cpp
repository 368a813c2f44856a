#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/refined_solve.h>
#include <ecorche/tissue/settling.h>

#include <algorithm>
#include <optional>
#include <string>

namespace ecorche::tissue {

namespace {

// Of a whole factor's work: above it, a whole one is made, which later ones share panels with.
constexpr double kMostShare = 0.8;
constexpr std::int64_t kGrain = 8192;

std::vector<std::int32_t> rowsWhere(const std::vector<std::uint8_t>& is) {
  std::vector<std::int32_t> out;
  for (std::size_t r = 0; r < is.size(); ++r) {
    if (is[r] != 0) out.push_back(static_cast<std::int32_t>(r));
  }
  return out;
}

}  // namespace

struct Settling::Impl {
  std::shared_ptr<const TissueSolver> solver;
  std::shared_ptr<const mesh::NeighbourRows> rows;
  // A whole factor and what it is of; later ones are made of it, so that no chain of them piles up
  std::shared_ptr<const mesh::SingleCholesky> whole;
  std::vector<double> wholeK;
  std::vector<std::int32_t> stubborn;  // what solves so far have found
  // The last solution, column by column, and what it solved
  FieldMatrix X;
  std::optional<SparseSides> b;
  std::vector<double> K;
  FieldMatrix spare;                // of X's size
  std::vector<std::string> column;  // names of tissues

  [[nodiscard]] std::vector<std::uint8_t> changed(const std::vector<double>& before,
                                                  const std::vector<double>& after) const;
  void start(const std::vector<CurveTissue>& tissues, FieldMatrix& out) const;
  [[nodiscard]] SparseSides rightSides(const CoreSamples& cores,
                                       const std::vector<CurveTissue>& tissues) const;
  Result<Settled> asWhole(const CoreSamples& cores, const std::vector<CurveTissue>& tissues,
                          const TissueOptions& options, RunContext& run) const;
};

Settling::Settling(std::shared_ptr<const TissueSolver> solver)
    : impl_(std::make_unique<Impl>(Impl{.solver = std::move(solver),
                                        .rows = {},
                                        .whole = {},
                                        .wholeK = {},
                                        .stubborn = {},
                                        .X = {},
                                        .b = {},
                                        .K = {},
                                        .spare = {},
                                        .column = {}})) {}
Settling::Settling(Settling&&) noexcept = default;
Settling& Settling::operator=(Settling&&) noexcept = default;
Settling::~Settling() = default;

const std::shared_ptr<const TissueSolver>& Settling::solver() const { return impl_->solver; }

// Rows of matrices that are others, both ends of every entry.
std::vector<std::uint8_t> Settling::Impl::changed(const std::vector<double>& before,
                                                  const std::vector<double>& after) const {
  const mesh::StiffnessPattern& pattern = solver->pattern();
  std::vector<std::uint8_t> is(static_cast<std::size_t>(pattern.rowCount()), 0);
  for (std::size_t r = 0; r < is.size(); ++r) {
    for (auto e = static_cast<std::size_t>(pattern.first[r]);
         e < static_cast<std::size_t>(pattern.first[r + 1]); ++e) {
      if (before[e] == after[e]) continue;
      is[r] = 1;
      is[static_cast<std::size_t>(pattern.index[e])] = 1;
    }
  }
  return is;
}

// Where a tissue was, its field is near; others begin at nothing.
void Settling::Impl::start(const std::vector<CurveTissue>& tissues, FieldMatrix& out) const {
  if (X.size() > 0 && std::ranges::equal(tissues, column, {}, &CurveTissue::name)) {
    out.resize(X.rows(), X.cols());
    parallelFor((X.rows() + kGrain - 1) / kGrain,
                [&](std::int64_t i) {
                  const Eigen::Index rows = std::min<Eigen::Index>(kGrain, X.rows() - i * kGrain);
                  out.middleRows(i * kGrain, rows) = X.middleRows(i * kGrain, rows);
                },
                1);
    return;
  }
  out.setZero(solver->pattern().rowCount(), static_cast<Eigen::Index>(tissues.size()) + 1);
  if (X.size() == 0) return;
  out.col(0) = X.col(0);
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    const auto was = std::ranges::find(column, tissues[i].name);
    if (was != column.end())
      out.col(static_cast<Eigen::Index>(i) + 1) = X.col((was - column.begin()) + 1);
  }
}

// Column 0: all curves at 1, which gives fat. Column i + 1: tissue i, Bᵀ W d.
SparseSides Settling::Impl::rightSides(const CoreSamples& cores,
                                       const std::vector<CurveTissue>& tissues) const {
  const mesh::StiffnessPattern& pattern = solver->pattern();
  const auto rowOf = [&](const CoreSample& s, int k) {
    return pattern.row[static_cast<std::size_t>(solver->domain().mesh.T(s.tet, k))];
  };
  std::vector<std::int32_t> all;
  for (const CoreSample& s : cores.samples) {
    for (int k = 0; k < 4; ++k) {
      if (rowOf(s, k) >= 0) all.push_back(rowOf(s, k));
    }
  }
  SparseSides out(pattern.rowCount(), std::move(all), std::ssize(tissues) + 1);
  for (const CoreSample& s : cores.samples) {
    const auto tissue = static_cast<std::size_t>(s.tissue.value - kFirstMuscle.value);
    const TissueCurve& curve = tissues[tissue].curves[static_cast<std::size_t>(s.curve)];
    const double target = curve.spline.interpolate(curve.values, s.u);
    for (int k = 0; k < 4; ++k) {
      if (rowOf(s, k) < 0) continue;
      auto b = out.value.row(out.place[static_cast<std::size_t>(rowOf(s, k))]);
      b[0] += s.weight * s.barycentric[k];
      b[static_cast<Eigen::Index>(tissue) + 1] += s.weight * target * s.barycentric[k];
    }
  }
  return out;
}

Result<Settling::Settled> Settling::Impl::asWhole(const CoreSamples& cores,
                                                  const std::vector<CurveTissue>& tissues,
                                                  const TissueOptions& options,
                                                  RunContext& run) const {
  auto factor = solver->factorise(cores, options, run);
  if (!factor) return passOn(factor);
  run.progress("tissue fields", 0.5);
  auto fields = solver->solve(*factor, cores, tissues, options, run);
  if (!fields) return passOn(fields);
  return Settled{std::move(*fields), std::move(*factor), nullptr, {}, 0, 1.0};
}

Result<Settling::Settled> Settling::solve(const CoreSamples& cores,
                                          const std::vector<CurveTissue>& tissues,
                                          const TissueOptions& options, RunContext& run) {
  const Stage stage(run, "tissue fields");
  Impl& I = *impl_;
  const auto cancelled = [] {
    return fail(ErrorCode::Cancelled, "cancelled while solving tissue fields");
  };
  const bool isotropic = std::ranges::all_of(
      tissues, [](const CurveTissue& tissue) { return tissue.anisotropy.isIsotropic(); });
  if (!isotropic || I.solver->symbolic() == nullptr) return I.asWhole(cores, tissues, options, run);
  if (run.cancelled()) return cancelled();
  if (auto held = I.solver->checkHeld(cores); !held) return passOn(held);

  std::vector<double> K = I.solver->stiffness();
  addRows(I.solver->domain(), I.solver->pattern(), cores.samples, 1.0, K);
  if (!I.rows)
    I.rows = std::make_shared<const mesh::NeighbourRows>(mesh::neighbourRows(I.solver->pattern()));
  const auto stop = [&] { return run.cancelled(); };
  std::shared_ptr<const mesh::SingleCholesky> factor;
  if (I.whole) {
    const auto changed = rowsWhere(I.changed(I.wholeK, K));
    if (changed.empty()) {
      factor = I.whole;
    } else if (I.whole->shareOf(changed) < kMostShare) {
      factor = std::make_shared<const mesh::SingleCholesky>(I.whole, K, changed, stop);
    }
  }
  const bool anew = factor == nullptr;
  if (anew) factor = std::make_shared<const mesh::SingleCholesky>(*I.solver->symbolic(), K, stop);
  if (run.cancelled()) return cancelled();
  if (!factor->ok()) return I.asWhole(cores, tissues, options, run);
  run.progress("tissue fields", 0.5);

  Settled out;
  out.factored = factor == I.whole ? 0.0 : factor->shareMade();
  out.ground = std::make_shared<DragGround>(I.solver, factor, std::move(K), I.rows);
  out.ground->stubborn = I.stubborn;
  FieldMatrix& X = I.spare;
  I.start(tissues, X);
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(X.cols());
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    for (const TissueCurve& curve : tissues[i].curves) {
      double& largest = scale[static_cast<Eigen::Index>(i) + 1];
      largest = std::max(largest, *std::ranges::max_element(curve.values));
    }
  }
  SparseSides b = I.rightSides(cores, tissues);
  // With the same tissues, only rows of what has been edited are not solved for
  std::vector<std::int32_t> edited;
  if (I.b && std::ranges::equal(tissues, I.column, {}, &CurveTissue::name)) {
    auto is = I.changed(I.K, out.ground->K);
    for (std::size_t r = 0; r < is.size(); ++r) {
      const std::int32_t now = b.place[r];
      const std::int32_t then = I.b->place[r];
      if (now < 0 && then < 0) continue;
      if (now < 0 || then < 0 || b.value.row(now) != I.b->value.row(then)) is[r] = 1;
    }
    edited = rowsWhere(is);
  }
  const Refined refined = refinedSolve(*out.ground, b, scale, X, stop, edited);
  if (run.cancelled()) return cancelled();
  if (!refined.done) return I.asWhole(cores, tissues, options, run);
  out.passes = refined.passes;
  out.ground->stubborn = refined.stubborn;
  run.progress("tissue fields", 0.9);
  auto fields = I.solver->fieldsOf(X, cores, tissues, options);
  if (!fields) return passOn(fields);
  out.fields = std::move(*fields);
  out.fat = Eigen::MatrixXd::Ones(out.fields.values.rows(), 1);
  for (Eigen::Index r = 0; r < X.rows(); ++r)
    out.fat(I.solver->pattern().vertex[static_cast<std::size_t>(r)], 0) -= X(r, 0);
  if (anew) {
    I.whole = std::move(factor);
    I.wholeK = out.ground->K;
  }
  std::swap(I.X, I.spare);
  I.b = std::move(b);
  I.K = out.ground->K;
  I.stubborn = out.ground->stubborn;
  I.column.clear();
  for (const CurveTissue& tissue : tissues) I.column.push_back(tissue.name);
  return out;
}

}  // namespace ecorche::tissue
