#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/own_field.h>
#include <ecorche/tissue/refined_solve.h>
#include <ecorche/tissue/sample_targets.h>
#include <ecorche/tissue/settling.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace ecorche::tissue {

namespace {

// Of a whole factor's work: above it, a whole one is made, which later ones share panels with.
constexpr double kMostRefactored = 0.8;
// Columns that an edit hardly changes are not looked at, so many times: what is left of each is
// less than 3e-10
constexpr int kMostLeftOut = 8;
constexpr std::int64_t kCopyGrain = 8192;

// Names of tissues in the order of their columns, after fat
std::vector<std::string> columnsOf(const std::vector<CurveTissue>& tissues) {
  std::vector<std::string> out;
  for (const CurveTissue& tissue : tissues) {
    if (tissue.anisotropy.isIsotropic()) out.push_back(tissue.name);
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
  FieldMatrix spare;                    // of X's size
  std::vector<std::string> column;      // names of isotropic tissues
  int leftOut = 0;                      // solves since all columns have been looked at
  std::map<std::string, OwnField> own;  // of anisotropic ones

  void start(const std::vector<std::string>& wanted, FieldMatrix& out) const;
  [[nodiscard]] SparseSides rightSides(const CoreSamples& cores,
                                       const std::vector<CurveTissue>& tissues) const;
  OwnField::Outcome solveOwn(const std::vector<double>& shared, const CoreSamples& cores,
                             const std::vector<CurveTissue>& tissues,
                             const std::function<bool()>& stop);
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
                                        .column = {},
                                        .leftOut = 0,
                                        .own = {}})) {}
Settling::Settling(Settling&&) noexcept = default;
Settling& Settling::operator=(Settling&&) noexcept = default;
Settling::~Settling() = default;

const std::shared_ptr<const TissueSolver>& Settling::solver() const { return impl_->solver; }

// Where a tissue was, its field is near; others begin at nothing.
void Settling::Impl::start(const std::vector<std::string>& wanted, FieldMatrix& out) const {
  if (X.size() > 0 && wanted == column) {
    out.resize(X.rows(), X.cols());
    parallelFor((X.rows() + kCopyGrain - 1) / kCopyGrain,
                [&](std::int64_t i) {
                  const Eigen::Index rows =
                      std::min<Eigen::Index>(kCopyGrain, X.rows() - i * kCopyGrain);
                  out.middleRows(i * kCopyGrain, rows) = X.middleRows(i * kCopyGrain, rows);
                },
                1);
    return;
  }
  out.setZero(solver->pattern().rowCount(), std::ssize(wanted) + 1);
  if (X.size() == 0) return;
  out.col(0) = X.col(0);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const auto was = std::ranges::find(column, wanted[i]);
    if (was != column.end())
      out.col(static_cast<Eigen::Index>(i) + 1) = X.col((was - column.begin()) + 1);
  }
}

// Column 0: all curves at 1, which gives fat. Then one per isotropic tissue, Bᵀ W d.
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
  std::vector<Eigen::Index> columnOf;
  Eigen::Index count = 1;
  for (const CurveTissue& tissue : tissues)
    columnOf.push_back(tissue.anisotropy.isIsotropic() ? count++ : -1);
  SparseSides out(pattern.rowCount(), std::move(all), count);
  const std::vector<double> targets = sampleTargets(cores.samples, tissues);
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const CoreSample& s = cores.samples[i];
    const auto tissue = static_cast<std::size_t>(s.tissue.value - kFirstMuscle.value);
    for (int k = 0; k < 4; ++k) {
      if (rowOf(s, k) < 0) continue;
      auto b = out.value.row(out.place[static_cast<std::size_t>(rowOf(s, k))]);
      b[0] += s.weight * s.barycentric[k];
      if (columnOf[tissue] >= 0) b[columnOf[tissue]] += s.weight * targets[i] * s.barycentric[k];
    }
  }
  return out;
}

// Fields of anisotropic tissues, each by its own equations; what is no longer there is forgotten.
OwnField::Outcome Settling::Impl::solveOwn(const std::vector<double>& shared,
                                           const CoreSamples& cores,
                                           const std::vector<CurveTissue>& tissues,
                                           const std::function<bool()>& stop) {
  std::map<std::string, OwnField> now;
  std::vector<std::size_t> which;
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    if (tissues[i].anisotropy.isIsotropic()) continue;
    which.push_back(i);
    const auto was = own.find(tissues[i].name);
    now.emplace(tissues[i].name, was != own.end() ? std::move(was->second) : OwnField());
  }
  own = std::move(now);
  const bool isFirst = std::ranges::any_of(own, [](const auto& it) { return !it.second.ground(); });
  std::once_flag once;
  std::optional<mesh::Cholesky> factor;
  const SharedEquations equations{
      shared,
      [&]() -> const mesh::Cholesky& {
        std::call_once(once, [&] { factor.emplace(*solver->symbolic(), shared, 1); });
        return *factor;
      },
      isFirst ? OwnField::wholeOf(*solver) : nullptr};
  std::vector<OwnField::Outcome> how(which.size());
  parallelFor(
      std::ssize(which),
      [&](std::int64_t k) {
        const std::size_t i = which[static_cast<std::size_t>(k)];
        how[static_cast<std::size_t>(k)] =
            own.at(tissues[i].name)
                .solve(*solver, equations, cores, tissues[i],
                       TissueId(kFirstMuscle.value + static_cast<std::int64_t>(i)), stop);
      },
      1);
  const auto other =
      std::ranges::find_if(how, [](OwnField::Outcome is) { return is != OwnField::Outcome::Done; });
  return other == how.end() ? OwnField::Outcome::Done : *other;
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
  return Settled{std::move(*fields), std::move(*factor), nullptr, {}, {}, 0, 0, 1.0};
}

Result<Settling::Settled> Settling::solve(const CoreSamples& cores,
                                          const std::vector<CurveTissue>& tissues,
                                          const TissueOptions& options, RunContext& run) {
  const Stage stage(run, "tissue fields");
  Impl& I = *impl_;
  const auto cancelled = [] {
    return fail(ErrorCode::Cancelled, "cancelled while solving tissue fields");
  };
  if (I.solver->symbolic() == nullptr) return I.asWhole(cores, tissues, options, run);
  if (run.cancelled()) return cancelled();
  if (auto held = I.solver->checkHeld(cores); !held) return passOn(held);

  std::vector<double> K = I.solver->stiffness();
  addRows(I.solver->domain().mesh, I.solver->pattern(), cores.samples, 1.0, K);
  if (!I.rows)
    I.rows = std::make_shared<const mesh::NeighbourRows>(mesh::neighbourRows(I.solver->pattern()));
  const auto stop = [&] { return run.cancelled(); };
  std::shared_ptr<const mesh::SingleCholesky> factor;
  if (I.whole) {
    const auto changed = rowsThatDiffer(I.solver->pattern(), I.wholeK, K);
    if (changed.empty()) {
      factor = I.whole;
    } else if (I.whole->shareOf(changed) < kMostRefactored) {
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
  out.ground = std::make_shared<DragGround>(
      std::shared_ptr<const mesh::StiffnessPattern>(I.solver, &I.solver->pattern()),
      std::shared_ptr<const mesh::SymbolicCholesky>(I.solver, I.solver->symbolic()),
      mesh::TreeSolver<float>(factor), std::move(K), I.rows);
  out.ground->single = factor;
  out.ground->stubborn = I.stubborn;
  FieldMatrix& X = I.spare;
  const std::vector<std::string> column = columnsOf(tissues);
  I.start(column, X);
  Eigen::VectorXd scale = Eigen::VectorXd::Ones(X.cols());
  Eigen::Index c = 1;
  for (const CurveTissue& tissue : tissues) {
    if (tissue.anisotropy.isIsotropic()) scale[c++] = std::max(1.0, tissue.largestValue());
  }
  SparseSides b = I.rightSides(cores, tissues);
  // With the same tissues, only rows of what has been edited are not solved for
  std::vector<std::int32_t> edited;
  if (I.b && column == I.column)
    edited = rowsThatDiffer(I.solver->pattern(), I.K, *I.b, out.ground->K, b);
  const Refined refined =
      refinedSolve(*out.ground, b, scale, X, stop, edited, I.leftOut == kMostLeftOut);
  if (run.cancelled()) return cancelled();
  if (!refined.done) return I.asWhole(cores, tissues, options, run);
  out.passes = refined.passes;
  out.leftOut = refined.leftOut;
  out.ground->stubborn = refined.stubborn;
  run.progress("tissue fields", 0.7);
  if (const auto how = I.solveOwn(out.ground->K, cores, tissues, stop);
      how != OwnField::Outcome::Done) {
    if (run.cancelled()) return cancelled();
    return I.asWhole(cores, tissues, options, run);
  }
  run.progress("tissue fields", 0.9);
  std::vector<OwnSolution> solved;
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    if (tissues[i].anisotropy.isIsotropic()) continue;
    const OwnField& field = I.own.at(tissues[i].name);
    out.own.push_back({i, field.ground()});
    solved.push_back({i, field.ground()->region->row, field.values()});
  }
  auto fields = I.solver->fieldsOf(X, solved, cores, tissues, options);
  if (!fields) return passOn(fields);
  out.fields = std::move(*fields);
  out.fat = Eigen::MatrixXd::Ones(out.fields.values.rows(), 1);
  for (Eigen::Index r = 0; r < X.rows(); ++r)
    out.fat(I.solver->pattern().vertex[static_cast<std::size_t>(r)], 0) -= X(r, 0);
  if (anew) {
    I.whole = std::move(factor);
    I.wholeK = out.ground->K;
  }
  I.leftOut = refined.leftOut > 0 ? I.leftOut + 1 : 0;
  std::swap(I.X, I.spare);
  I.b = std::move(b);
  I.K = out.ground->K;
  I.stubborn = out.ground->stubborn;
  I.column = column;
  return out;
}

}  // namespace ecorche::tissue
