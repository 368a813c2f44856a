#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/refined_solve.h>
#include <ecorche/tissue/settling.h>

#include <algorithm>
#include <string>

namespace ecorche::tissue {

namespace {

// Of a whole factor's work: above it, a whole one is made, which later ones share panels with.
constexpr double kMostShare = 0.8;

}  // namespace

struct Settling::Impl {
  std::shared_ptr<const TissueSolver> solver;
  std::shared_ptr<const mesh::NeighbourRows> rows;
  // A whole factor and what it is of; later ones are made of it, so that no chain of them piles up
  std::shared_ptr<const mesh::SingleCholesky> whole;
  std::vector<double> wholeK;
  // The last solution, column by column
  FieldMatrix X;
  std::vector<std::string> column;  // names of tissues

  [[nodiscard]] std::vector<std::int32_t> changedRows(const std::vector<double>& K) const;
  [[nodiscard]] FieldMatrix start(const std::vector<CurveTissue>& tissues) const;
  Result<Settled> asWhole(const CoreSamples& cores, const std::vector<CurveTissue>& tissues,
                          const TissueOptions& options, RunContext& run) const;
};

Settling::Settling(std::shared_ptr<const TissueSolver> solver)
    : impl_(std::make_unique<Impl>(Impl{.solver = std::move(solver),
                                        .rows = {},
                                        .whole = {},
                                        .wholeK = {},
                                        .X = {},
                                        .column = {}})) {}
Settling::Settling(Settling&&) noexcept = default;
Settling& Settling::operator=(Settling&&) noexcept = default;
Settling::~Settling() = default;

const std::shared_ptr<const TissueSolver>& Settling::solver() const { return impl_->solver; }

std::vector<std::int32_t> Settling::Impl::changedRows(const std::vector<double>& K) const {
  const mesh::StiffnessPattern& pattern = solver->pattern();
  std::vector<std::uint8_t> is(static_cast<std::size_t>(pattern.rowCount()), 0);
  for (std::size_t r = 0; r < is.size(); ++r) {
    for (auto e = static_cast<std::size_t>(pattern.first[r]);
         e < static_cast<std::size_t>(pattern.first[r + 1]); ++e) {
      if (K[e] == wholeK[e]) continue;
      is[r] = 1;
      is[static_cast<std::size_t>(pattern.index[e])] = 1;
    }
  }
  std::vector<std::int32_t> out;
  for (std::size_t r = 0; r < is.size(); ++r) {
    if (is[r] != 0) out.push_back(static_cast<std::int32_t>(r));
  }
  return out;
}

// Where a tissue was, its field is near; others begin at nothing.
FieldMatrix Settling::Impl::start(const std::vector<CurveTissue>& tissues) const {
  FieldMatrix out = FieldMatrix::Zero(solver->pattern().rowCount(),
                                      static_cast<Eigen::Index>(tissues.size()) + 1);
  if (X.size() == 0) return out;
  const bool same = std::ranges::equal(tissues, column, {}, &CurveTissue::name);
  if (same) return X;
  out.col(0) = X.col(0);
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    const auto was = std::ranges::find(column, tissues[i].name);
    if (was != column.end())
      out.col(static_cast<Eigen::Index>(i) + 1) = X.col((was - column.begin()) + 1);
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
    const std::vector<std::int32_t> changed = I.changedRows(K);
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
  FieldMatrix X = I.start(tissues);
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(X.cols());
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    for (const TissueCurve& curve : tissues[i].curves) {
      double& largest = scale[static_cast<Eigen::Index>(i) + 1];
      largest = std::max(largest, *std::ranges::max_element(curve.values));
    }
  }
  const Refined refined =
      refinedSolve(*out.ground, I.solver->rightSides(cores, tissues), scale, X, stop);
  if (run.cancelled()) return cancelled();
  if (!refined.done) return I.asWhole(cores, tissues, options, run);
  out.passes = refined.passes;
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
  I.X = std::move(X);
  I.column.clear();
  for (const CurveTissue& tissue : tissues) I.column.push_back(tissue.name);
  return out;
}

}  // namespace ecorche::tissue
