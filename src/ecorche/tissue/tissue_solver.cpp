#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/mesh/cholesky.h>
#include <ecorche/mesh/operators.h>
#include <ecorche/tissue/near_curves.h>
#include <ecorche/tissue/sample_targets.h>
#include <ecorche/tissue/spread_tensors.h>
#include <ecorche/tissue/tissue_solver.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <optional>

// Letters as in the paper: K system, B core rows, W weights, d targets, A tensors. Rows of K are
// the vertices that are not skin; fields are 0 on skin, so columns of skin vertices never appear.

namespace ecorche::tissue {

using domain::Domain;
using mesh::Vector3;

namespace {

tl::unexpected<Error> cancelled() {
  return fail(ErrorCode::Cancelled, "cancelled while solving tissue fields");
}

// Components of the free vertices, to find those that nothing holds: there K is singular, and a
// factorisation may still say success and answer with values near 1e16.
struct Components {
  std::vector<std::int32_t> ofRow;
  std::vector<std::uint8_t> touchesSkin;  // per component
};

Components findComponents(const mesh::TetMesh& mesh, const mesh::StiffnessPattern& pattern) {
  Components out;
  out.ofRow.assign(pattern.vertex.size(), -1);
  std::vector<std::int32_t> queue;
  for (std::int32_t seed = 0; seed < pattern.rowCount(); ++seed) {
    if (out.ofRow[static_cast<std::size_t>(seed)] >= 0) continue;
    const auto component = static_cast<std::int32_t>(out.touchesSkin.size());
    out.touchesSkin.push_back(0);
    queue.assign(1, seed);
    out.ofRow[static_cast<std::size_t>(seed)] = component;
    while (!queue.empty()) {
      const auto v =
          static_cast<std::size_t>(pattern.vertex[static_cast<std::size_t>(queue.back())]);
      queue.pop_back();
      for (auto i = pattern.vertexTets.first[v]; i < pattern.vertexTets.first[v + 1]; ++i) {
        const auto t = pattern.vertexTets.tet[static_cast<std::size_t>(i)];
        for (int k = 0; k < 4; ++k) {
          const std::int32_t r = pattern.row[static_cast<std::size_t>(mesh.T(t, k))];
          if (r < 0) {
            out.touchesSkin[static_cast<std::size_t>(component)] = 1;
          } else if (out.ofRow[static_cast<std::size_t>(r)] < 0) {
            out.ofRow[static_cast<std::size_t>(r)] = component;
            queue.push_back(r);
          }
        }
      }
    }
  }
  return out;
}

std::size_t tissueOf(const CoreSample& s) {
  return static_cast<std::size_t>(s.tissue.value - kFirstMuscle.value);
}

}  // namespace

struct TissueSolver::Impl {
  const Domain& domain;
  mesh::StiffnessPattern pattern;
  std::optional<mesh::SymbolicCholesky> symbolic;
  std::vector<double> L;  // isotropic stiffness on the pattern
  Components components;
  Findings findings;

  explicit Impl(const Domain& d) : domain(d) {}

  [[nodiscard]] std::int32_t row(const CoreSample& s, int k) const {
    return pattern.row[static_cast<std::size_t>(domain.mesh.T(s.tet, k))];
  }
  [[nodiscard]] Vector3 place(std::int64_t r) const {
    return domain.mesh.V.row(pattern.vertex[static_cast<std::size_t>(r)]).transpose();
  }

  // K += Bᵀ W B: a row lives inside one tet, so it adds no fill
  template <class Weight>
  void addCores(const CoreSamples& cores, const Weight& weight, std::vector<double>& K) const {
    for (const CoreSample& s : cores.samples) {
      const double w = weight(s);
      for (int k = 0; k < 4; ++k) {
        const std::int32_t r = row(s, k);
        if (r < 0) continue;
        K[static_cast<std::size_t>(pattern.diagonal(r))] += w * s.barycentric[k] * s.barycentric[k];
      }
      for (std::size_t e = 0; e < 6; ++e) {
        const std::int32_t slot = pattern.edgeSlot[static_cast<std::size_t>(s.tet)][e];
        if (slot < 0) continue;
        K[static_cast<std::size_t>(slot)] +=
            w * s.barycentric[mesh::kTetEdge[e][0]] * s.barycentric[mesh::kTetEdge[e][1]];
      }
    }
  }

  // Column += w d Bᵀ of one row
  void addTarget(const CoreSample& s, double wd, Eigen::Ref<Eigen::VectorXd> column) const {
    for (int k = 0; k < 4; ++k) {
      const std::int32_t r = row(s, k);
      if (r >= 0) column[r] += wd * s.barycentric[k];
    }
  }

  [[nodiscard]] Result<void> checkHeld(const CoreSamples& cores) const {
    std::vector<std::uint8_t> held = components.touchesSkin;
    for (const CoreSample& s : cores.samples) {
      for (int k = 0; k < 4; ++k) {
        const std::int32_t r = row(s, k);
        if (r >= 0)
          held[static_cast<std::size_t>(components.ofRow[static_cast<std::size_t>(r)])] = 1;
      }
    }
    for (std::size_t r = 0; r < components.ofRow.size(); ++r) {
      if (held[static_cast<std::size_t>(components.ofRow[r])] != 0) continue;
      const Vector3 p = place(static_cast<std::int64_t>(r));
      return fail(
          ErrorCode::ComponentWithoutSkin,
          fmt::format(
              "a part of the domain at ({:.4g}, {:.4g}, {:.4g}) m touches neither skin nor curve; "
              "close the gap between bones there or draw a curve through it",
              p.x(), p.y(), p.z()),
          {.point = p});
    }
    return {};
  }

  // Logarithm of a tissue's tensor on its own rows, and their weights: seven right-hand sides
  void addTensorTargets(const CoreSamples& cores, const CurveTissue& tissue, TissueId id,
                        Eigen::Ref<Eigen::MatrixXd> columns) const {
    std::vector<CoreSample> own;
    std::ranges::copy_if(cores.samples, std::back_inserter(own),
                         [&](const CoreSample& s) { return s.tissue == id; });
    const auto entries = tensorEntries(domain, tissue, own);
    for (std::size_t i = 0; i < own.size(); ++i) {
      for (std::size_t e = 0; e < entries[i].size(); ++e)
        addTarget(own[i], own[i].weight * entries[i][e], columns.col(static_cast<Eigen::Index>(e)));
    }
  }

  // An anisotropic tissue's own equations, from the spread logarithms
  struct OwnSystem {
    mesh::Cholesky factor;
    std::vector<double> weight;  // per sample
  };
  [[nodiscard]] Result<OwnSystem> ownSystem(const CoreSamples& cores, const CurveTissue& tissue,
                                            const Eigen::Ref<const Eigen::MatrixXd>& spread) const {
    const auto A = tetTensors(domain.mesh, pattern, spread, tissue.anisotropy);
    std::vector<double> K =
        mesh::assembleStiffness(domain.mesh, pattern, mesh::edgeStiffness(domain.mesh, A));
    const auto weight = [&](const CoreSample& s) {
      return weightIn(A[static_cast<std::size_t>(s.tet)], s);
    };
    addCores(cores, weight, K);
    OwnSystem out{mesh::Cholesky(*symbolic, K, 1), {}};
    if (!out.factor.ok()) return singular(out.factor, tissue.name);
    for (const CoreSample& s : cores.samples) out.weight.push_back(weight(s));
    return out;
  }

  // Rows to vertices, 0 on skin
  [[nodiscard]] Eigen::MatrixXd atVertices(const Eigen::MatrixXd& X) const {
    Eigen::MatrixXd out = Eigen::MatrixXd::Zero(domain.mesh.V.rows(), X.cols());
    for (Eigen::Index c = 0; c < X.cols(); ++c) {
      for (Eigen::Index r = 0; r < X.rows(); ++r)
        out(pattern.vertex[static_cast<std::size_t>(r)], c) = X(r, c);
    }
    return out;
  }

  // Fields before anything is solved: fat on skin
  struct Begun {
    TissueFields fields;
    std::vector<double> largest;  // per tissue
    double fat = 0.0;
  };
  [[nodiscard]] Begun begin(const std::vector<CurveTissue>& tissues,
                            const TissueOptions& options) const {
    Begun begun;
    begun.fat = options.fat;
    TissueFields& out = begun.fields;
    std::vector<double>& largest = begun.largest;
    out.findings = findings;
    out.fatIsCandidate = options.fat > 0.0;
    out.maxValue = options.fat;
    largest.assign(tissues.size(), 0.0);
    for (std::size_t i = 0; i < tissues.size(); ++i) {
      largest[i] = tissues[i].largestValue();
      out.maxValue = std::max(out.maxValue, largest[i]);
    }
    // 280 MB for the whole dog: the system hands out memory as it is written, by all threads
    out.values.resize(domain.mesh.V.rows(), std::ssize(tissues) + 1);
    parallelFor(out.values.rows(), [&](std::int64_t v) {
      out.values.row(v).setZero();
      if (domain.onSkin[static_cast<std::size_t>(v)] != 0) out.values(v, 0) = options.fat;
    });
    return begun;
  }

  // What follows once rows are solved
  [[nodiscard]] Result<TissueFields> finish(Begun begun, const CoreSamples& cores,
                                            const std::vector<double>& target) const {
    TissueFields& out = begun.fields;
    out.uncorrected = correctNearCurves(domain, cores, target, out.values);

    // How far poor tets break the maximum principle
    const Eigen::Index k = out.values.cols();
    constexpr std::int64_t kRows = 256;  // stay at hand while they are looked at twice
    const std::int64_t chunks = (out.values.rows() + kRows - 1) / kRows;
    Eigen::MatrixXd lowest = Eigen::MatrixXd::Zero(k, chunks);
    Eigen::MatrixXd highest = Eigen::MatrixXd::Zero(k, chunks);
    std::vector<std::uint8_t> finite(static_cast<std::size_t>(chunks));
    parallelFor(
        chunks,
        [&](std::int64_t chunk) {
          const auto rows = out.values.middleRows(
              chunk * kRows, std::min<std::int64_t>(kRows, out.values.rows() - chunk * kRows));
          for (const auto& row : rows.rowwise()) {
            lowest.col(chunk) = lowest.col(chunk).cwiseMin(row.transpose());
            highest.col(chunk) = highest.col(chunk).cwiseMax(row.transpose());
          }
          finite[static_cast<std::size_t>(chunk)] = rows.allFinite() ? 1 : 0;
        },
        1);
    if (std::ranges::find(finite, 0) != finite.end()) {
      return fail(ErrorCode::SystemSingular,
                  "the tissue fields are not finite; build the domain at another resolution");
    }
    if (out.maxValue > 0.0) {
      const Eigen::VectorXd most = highest.rowwise().maxCoeff();
      out.undershoot = std::max(0.0, -lowest.minCoeff()) / out.maxValue;
      out.overshoot = std::max(0.0, most[0] - begun.fat) / out.maxValue;
      for (std::size_t i = 0; i < begun.largest.size(); ++i) {
        out.overshoot =
            std::max(out.overshoot,
                     (most[static_cast<Eigen::Index>(i) + 1] - begun.largest[i]) / out.maxValue);
      }
    }
    return std::move(out);
  }

  [[nodiscard]] tl::unexpected<Error> singular(const mesh::Cholesky& factor,
                                               const std::string& who) const {
    const Vector3 p = place(factor.badRow());
    return fail(ErrorCode::SystemSingular,
                fmt::format("the equations of {} have no stable solution near ({:.4g}, {:.4g}, "
                            "{:.4g}) m: tets there "
                            "are too flat; build the domain at another resolution",
                            who, p.x(), p.y(), p.z()),
                {.object = who, .point = p});
  }
};

TissueSolver::TissueSolver(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TissueSolver::TissueSolver(TissueSolver&&) noexcept = default;
TissueSolver& TissueSolver::operator=(TissueSolver&&) noexcept = default;
TissueSolver::~TissueSolver() = default;

const domain::Domain& TissueSolver::domain() const { return impl_->domain; }
const mesh::StiffnessPattern& TissueSolver::pattern() const { return impl_->pattern; }
const std::vector<double>& TissueSolver::stiffness() const { return impl_->L; }
Result<void> TissueSolver::checkHeld(const CoreSamples& cores) const {
  return impl_->checkHeld(cores);
}
const mesh::SymbolicCholesky* TissueSolver::symbolic() const {
  return impl_->symbolic ? &*impl_->symbolic : nullptr;
}
double TissueSolver::factorEntries() const { return impl_->symbolic->factorEntries(); }

Result<TissueSolver> TissueSolver::create(const Domain& domain, RunContext& run) {
  const Stage stage(run, "tissue analysis");
  if (run.cancelled()) return cancelled();
  auto impl = std::make_unique<Impl>(domain);
  impl->pattern = mesh::stiffnessPattern(domain.mesh, domain.onSkin);
  run.progress("tissue analysis", 0.2);
  if (run.cancelled()) return cancelled();

  const mesh::EdgeStiffness stiffness = mesh::edgeStiffness(domain.mesh);
  impl->L = mesh::assembleStiffness(domain.mesh, impl->pattern, stiffness);
  impl->components = findComponents(domain.mesh, impl->pattern);
  if (!stiffness.flattened.empty()) {
    const Vector3 p =
        domain.mesh.V(domain.mesh.T.row(stiffness.flattened.front()), Eigen::all).colwise().mean();
    impl->findings.push_back(
        {Severity::Repaired, "sliver-energy", "domain",
         fmt::format("{} tets are so flat that their part in the energy was capped; fields there "
                     "are smoother than they should be",
                     stiffness.flattened.size()),
         p, static_cast<double>(stiffness.flattened.size())});
  }
  run.progress("tissue analysis", 0.4);
  if (run.cancelled()) return cancelled();
  if (impl->pattern.rowCount() > 0) impl->symbolic.emplace(impl->pattern);
  if (run.cancelled()) return cancelled();
  return TissueSolver(std::move(impl));
}

Result<TissueSolver::Factor> TissueSolver::factorise(const CoreSamples& cores,
                                                     const TissueOptions& options,
                                                     RunContext& run) const {
  const Impl& I = *impl_;
  if (run.cancelled()) return cancelled();
  if (auto held = I.checkHeld(cores); !held) return passOn(held);
  if (I.pattern.rowCount() == 0) return Factor();

  // One factor serves fat, every isotropic field and the spreading of tensors: K = L + Bᵀ W B
  std::vector<double> K = I.L;
  I.addCores(
      cores, [](const CoreSample& s) { return s.weight; }, K);
  auto factor = std::make_shared<const mesh::Cholesky>(*I.symbolic, K, options.factorThreads);
  if (!factor->ok()) return I.singular(*factor, "the tissue fields");
  if (run.cancelled()) return cancelled();
  return factor;
}

Result<TissueFields> TissueSolver::solve(const CoreSamples& cores,
                                         const std::vector<CurveTissue>& tissues,
                                         const TissueOptions& options, RunContext& run) const {
  const Stage stage(run, "tissue fields");
  auto factor = factorise(cores, options, run);
  if (!factor) return passOn(factor);
  run.progress("tissue fields", 0.5);
  return solve(*factor, cores, tissues, options, run);
}

Eigen::MatrixXd TissueSolver::solveFat(const Factor& factor, const CoreSamples& cores) const {
  const Impl& I = *impl_;
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(I.pattern.rowCount(), 1);
  for (const CoreSample& s : cores.samples) I.addTarget(s, s.weight, X.col(0));
  if (factor) factor->solveInPlace(X);
  X = (1.0 - X.array()).matrix();
  Eigen::MatrixXd out = I.atVertices(X);
  for (std::size_t v = 0; v < I.domain.onSkin.size(); ++v) {
    if (I.domain.onSkin[v] != 0) out(static_cast<Eigen::Index>(v), 0) = 1.0;
  }
  return out;
}

Result<Eigen::MatrixXd> TissueSolver::solveTargets(const Factor& factor, const CoreSamples& cores,
                                                   const std::vector<CurveTissue>& tissues,
                                                   std::size_t tissue,
                                                   const Eigen::MatrixXd& targets,
                                                   RunContext& run) const {
  EC_REQUIRE_EQ(static_cast<std::size_t>(targets.rows()), cores.samples.size());
  const Impl& I = *impl_;
  const TissueId id(kFirstMuscle.value + static_cast<std::int64_t>(tissue));
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(I.pattern.rowCount(), targets.cols());
  if (!factor) return I.atVertices(X);
  std::optional<Impl::OwnSystem> own;
  if (!tissues[tissue].anisotropy.isIsotropic()) {
    Eigen::MatrixXd spread = Eigen::MatrixXd::Zero(I.pattern.rowCount(), 7);
    I.addTensorTargets(cores, tissues[tissue], id, spread);
    factor->solveInPlace(spread, [&] { return run.cancelled(); });
    if (run.cancelled()) return cancelled();
    auto made = I.ownSystem(cores, tissues[tissue], spread);
    if (!made) return passOn(made);
    own.emplace(std::move(*made));
  }
  for (std::size_t s = 0; s < cores.samples.size(); ++s) {
    if (cores.samples[s].tissue != id) continue;
    const double weight = own ? own->weight[s] : cores.samples[s].weight;
    for (Eigen::Index c = 0; c < targets.cols(); ++c)
      I.addTarget(cores.samples[s], weight * targets(static_cast<Eigen::Index>(s), c), X.col(c));
  }
  (own ? own->factor : *factor).solveInPlace(X, [&] { return run.cancelled(); });
  if (run.cancelled()) return cancelled();
  return I.atVertices(X);
}

Result<TissueFields> TissueSolver::solve(const Factor& factor, const CoreSamples& cores,
                                         const std::vector<CurveTissue>& tissues,
                                         const TissueOptions& options, RunContext& run) const {
  const Impl& I = *impl_;
  if (run.cancelled()) return cancelled();
  const Eigen::Index n = I.pattern.rowCount();

  Impl::Begun begun = I.begin(tissues, options);
  TissueFields& out = begun.fields;
  if (n == 0) return std::move(out);

  // Right-hand sides. Column 0: all curves at 1, for fat. One per isotropic tissue: Bᵀ W d. Seven
  // per anisotropic one: the logarithm of its tensor on its own rows, and their weights.
  std::vector<Eigen::Index> column(tissues.size());
  Eigen::Index columnCount = 1;
  std::vector<std::size_t> anisotropic;
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    column[i] = columnCount;
    const bool isotropic = tissues[i].anisotropy.isIsotropic();
    columnCount += isotropic ? 1 : 7;
    if (!isotropic) anisotropic.push_back(i);
  }
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(n, columnCount);
  const std::vector<double> target = sampleTargets(cores.samples, tissues);
  for (std::size_t s = 0; s < cores.samples.size(); ++s) {
    const CoreSample& sample = cores.samples[s];
    I.addTarget(sample, sample.weight, X.col(0));
    if (tissues[tissueOf(sample)].anisotropy.isIsotropic()) {
      I.addTarget(sample, sample.weight * target[s], X.col(column[tissueOf(sample)]));
    }
  }
  for (const std::size_t i : anisotropic) {
    I.addTensorTargets(cores, tissues[i],
                       TissueId(kFirstMuscle.value + static_cast<std::int64_t>(i)),
                       X.middleCols(column[i], 7));
  }
  factor->solveInPlace(X, [&] { return run.cancelled(); });
  if (run.cancelled()) return cancelled();
  run.progress("tissue fields", 0.8);

  // Anisotropic tissues have their own matrix on the same pattern
  std::mutex mutex;
  std::optional<Error> error;
  std::vector<Eigen::VectorXd> own(tissues.size());
  parallelFor(
      static_cast<std::int64_t>(anisotropic.size()),
      [&](std::int64_t k) {
        if (run.cancelled()) return;
        const std::size_t i = anisotropic[static_cast<std::size_t>(k)];
        auto system = I.ownSystem(cores, tissues[i], X.middleCols(column[i], 7));
        if (run.cancelled()) return;
        if (!system) {
          const std::lock_guard lock(mutex);
          if (!error) error = system.error();
          return;
        }
        Eigen::MatrixXd x = Eigen::MatrixXd::Zero(n, 1);
        for (std::size_t s = 0; s < cores.samples.size(); ++s) {
          if (tissueOf(cores.samples[s]) != i) continue;
          I.addTarget(cores.samples[s], system->weight[s] * target[s], x.col(0));
        }
        system->factor.solveInPlace(x);
        own[i] = x.col(0);
      },
      1);
  if (run.cancelled()) return cancelled();
  if (error) return tl::unexpected<Error>(std::move(*error));

  // Fat is what the curves leave: f_s = d_fat (1 − φ), φ the field with all curves at 1
  parallelFor(n, [&](std::int64_t r) {
    auto f = out.values.row(I.pattern.vertex[static_cast<std::size_t>(r)]);
    f[0] = options.fat * (1.0 - X(r, 0));
    for (std::size_t i = 0; i < tissues.size(); ++i) {
      f[static_cast<Eigen::Index>(i) + 1] = own[i].size() > 0 ? own[i][r] : X(r, column[i]);
    }
  });

  return I.finish(std::move(begun), cores, target);
}

Result<TissueFields> TissueSolver::fieldsOf(const FieldMatrix& X,
                                            const std::vector<OwnSolution>& own,
                                            const CoreSamples& cores,
                                            const std::vector<CurveTissue>& tissues,
                                            const TissueOptions& options) const {
  const Impl& I = *impl_;
  EC_REQUIRE_EQ(X.cols() + std::ssize(own), std::ssize(tissues) + 1);
  Impl::Begun begun = I.begin(tissues, options);
  FieldMatrix& values = begun.fields.values;
  std::vector<Eigen::Index> field{0};
  for (std::size_t i = 0; i < tissues.size(); ++i) {
    if (tissues[i].anisotropy.isIsotropic()) field.push_back(static_cast<Eigen::Index>(i) + 1);
  }
  parallelFor(I.pattern.rowCount(), [&](std::int64_t r) {
    auto f = values.row(I.pattern.vertex[static_cast<std::size_t>(r)]);
    if (own.empty()) {
      f = X.row(r);
    } else {
      for (std::size_t c = 1; c < field.size(); ++c)
        f[field[c]] = X(r, static_cast<Eigen::Index>(c));
    }
    f[0] = options.fat * (1.0 - X(r, 0));
  });
  for (const OwnSolution& solution : own) {
    for (std::size_t i = 0; i < solution.row.size(); ++i) {
      const auto v = I.pattern.vertex[static_cast<std::size_t>(solution.row[i])];
      values(v, static_cast<Eigen::Index>(solution.tissue) + 1) =
          solution.values[static_cast<Eigen::Index>(i)];
    }
  }
  return I.finish(std::move(begun), cores, sampleTargets(cores.samples, tissues));
}

Result<TissueFields> solveTissueFields(const Domain& domain, const CoreSamples& cores,
                                       const std::vector<CurveTissue>& tissues,
                                       const TissueOptions& options, RunContext& run) {
  const auto solver = TissueSolver::create(domain, run);
  if (!solver) return passOn(solver);
  return solver->solve(cores, tissues, options, run);
}

}  // namespace ecorche::tissue
