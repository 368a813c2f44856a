#include <ecorche/core/contract.h>
#include <ecorche/core/parallel.h>
#include <ecorche/tissue/moved_fields.h>
#include <ecorche/tissue/near_curves.h>
#include <ecorche/tissue/refined_solve.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/value_fields.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <list>

// Letters as in tissue_solver.cpp: D values at control points, φ the fields of unit values.

namespace ecorche::tissue {

namespace {

constexpr std::int64_t kOwnerGrain = 8192;

// Of values that are as good as proportional to others, relative
constexpr double kSame = 1e-14;

// What is known of a tissue's equations. Fat is field 0, tissue i is field i + 1
struct Basis {
  Eigen::Index field = 0;
  Eigen::MatrixXd hat;  // #samples×#points: what D_p is worth at each sample of its own
  std::vector<Eigen::VectorXd> phi;  // of every point, raw; empty: nobody asked for it yet
  Eigen::VectorXd D;                 // that raw is of
  Eigen::VectorXd raw;               // φ D; empty: not solved for yet
};

Eigen::VectorXd valuesAt(const std::vector<std::vector<double>>& values) {
  std::vector<double> all;
  for (const auto& curve : values) all.insert(all.end(), curve.begin(), curve.end());
  return Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

// D = scale · before, but for the points in `moved`
struct Step {
  double scale = 1.0;
  std::vector<Eigen::Index> moved;
};

// A muscle as a whole made thicker needs no φ at all
Step stepTo(const Eigen::VectorXd& before, const Eigen::VectorXd& D) {
  const auto movedUnder = [&](double scale) {
    std::vector<Eigen::Index> moved;
    for (Eigen::Index k = 0; k < D.size(); ++k) {
      if (std::abs(D[k] - scale * before[k]) > kSame * D[k]) moved.push_back(k);
    }
    return moved;
  };
  Step one{1.0, movedUnder(1.0)};
  if (one.moved.size() < 2 || !(before[0] > 0.0)) return one;
  Step all{D[0] / before[0], {}};
  all.moved = movedUnder(all.scale);
  return all.moved.size() < one.moved.size() ? all : one;
}

}  // namespace

struct ValueFields::Impl {
  std::shared_ptr<const domain::Domain> domain;
  std::shared_ptr<const TissueSolver> solver;
  TissueSolver::Factor factor;  // null where `ground` is all there is
  CoreSamples cores;
  std::vector<CurveTissue> tissues;
  TissueOptions options;
  TissueFields fields;
  std::vector<TissueId> owner;

  std::list<Basis> ready;  // the last one used first
  std::optional<Eigen::MatrixXd> phiFat;

  // The largest of the other fields at every vertex, for the one field that is being edited
  Eigen::Index rivalsOf = -1;
  std::vector<double> rival;
  std::vector<std::int32_t> rivalField;  // -1: there is none

  // Curves that were moved
  std::shared_ptr<const CurveWalker> walker;
  std::shared_ptr<DragGround> ground;
  std::vector<OwnEquations> own;  // of anisotropic tissues, where they were settled beside it
  std::unique_ptr<MovedFields> moving;
  std::vector<CurveTissue> settled;  // tissues that the factor is of
  bool adrift = false;

  Eigen::VectorXd lastTold;   // its values as Changed last told of them
  Eigen::VectorXd corrected;  // of the last edit

  [[nodiscard]] Eigen::Index vertexCount() const { return domain->mesh.V.rows(); }
  [[nodiscard]] bool stands() const { return factor != nullptr || ground != nullptr; }
  [[nodiscard]] Result<Eigen::MatrixXd> solveRows(TissueId id, const Eigen::MatrixXd& targets,
                                                  RunContext& run);
  void findRivals(Eigen::Index field);
  Changed take(Eigen::Index field);
  void keepUncorrected(Eigen::Index field, const Eigen::VectorXd& raw);
  void stand();
  MovedFields::Told begin(std::vector<CurveRef> curves);
  [[nodiscard]] Basis& basisOf(std::size_t tissue);
  [[nodiscard]] Result<void> solveFor(Basis& basis, const std::vector<Eigen::Index>& points,
                                      RunContext& run);
};

ValueFields::ValueFields(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ValueFields::ValueFields(ValueFields&&) noexcept = default;
ValueFields& ValueFields::operator=(ValueFields&&) noexcept = default;
ValueFields::~ValueFields() = default;

const TissueFields& ValueFields::fields() const { return impl_->fields; }
const domain::Domain& ValueFields::domain() const { return *impl_->domain; }
const CoreSamples& ValueFields::cores() const { return impl_->cores; }
const std::vector<CurveTissue>& ValueFields::tissues() const { return impl_->tissues; }
const std::vector<TissueId>& ValueFields::owners() const { return impl_->owner; }
double ValueFields::fat() const { return impl_->options.fat; }

Result<ValueFields> ValueFields::create(std::shared_ptr<const domain::Domain> domain,
                                        std::shared_ptr<const TissueSolver> solver,
                                        CoreSamples cores, std::vector<CurveTissue> tissues,
                                        TissueOptions options, RunContext& run,
                                        std::shared_ptr<const CurveWalker> walker) {
  const Stage stage(run, "tissue fields");
  auto impl = std::make_unique<Impl>();
  impl->domain = std::move(domain);
  impl->solver = std::move(solver);
  impl->cores = std::move(cores);
  impl->tissues = std::move(tissues);
  impl->options = options;
  impl->walker = std::move(walker);
  auto factor = impl->solver->factorise(impl->cores, options, run);
  if (!factor) return passOn(factor);
  impl->factor = std::move(*factor);
  auto fields = impl->solver->solve(impl->factor, impl->cores, impl->tissues, options, run);
  if (!fields) return passOn(fields);
  impl->fields = std::move(*fields);
  impl->owner = vertexOwners(impl->fields);
  return ValueFields(std::move(impl));
}

ValueFields ValueFields::create(std::shared_ptr<const domain::Domain> domain,
                                std::shared_ptr<const TissueSolver> solver,
                                Settling::Settled settled, CoreSamples cores,
                                std::vector<CurveTissue> tissues, TissueOptions options,
                                std::shared_ptr<const CurveWalker> walker) {
  auto impl = std::make_unique<Impl>();
  impl->domain = std::move(domain);
  impl->solver = std::move(solver);
  impl->cores = std::move(cores);
  impl->tissues = std::move(tissues);
  impl->options = options;
  impl->walker = std::move(walker);
  impl->factor = std::move(settled.factor);
  impl->ground = std::move(settled.ground);
  impl->own = std::move(settled.own);
  impl->fields = std::move(settled.fields);
  if (settled.fat.size() > 0) impl->phiFat = std::move(settled.fat);
  impl->owner = vertexOwners(impl->fields);
  return ValueFields(std::move(impl));
}

Result<ValueFields> ValueFields::create(std::shared_ptr<const domain::Domain> domain,
                                        Settling& settling, CoreSamples cores,
                                        std::vector<CurveTissue> tissues, TissueOptions options,
                                        RunContext& run,
                                        std::shared_ptr<const CurveWalker> walker) {
  auto settled = settling.solve(cores, tissues, options, run);
  if (!settled) return passOn(settled);
  return create(std::move(domain), settling.solver(), std::move(*settled), std::move(cores),
                std::move(tissues), options, std::move(walker));
}

// One tissue's equations for other targets, by the 32-bit factor unless it will not do.
Result<Eigen::MatrixXd> ValueFields::Impl::solveRows(TissueId id, const Eigen::MatrixXd& targets,
                                                     RunContext& run) {
  const auto tissue = static_cast<std::size_t>(id.value - kFirstMuscle.value);
  std::vector<CoreSample> samples;
  std::vector<std::size_t> which;
  for (std::size_t s = 0; s < cores.samples.size(); ++s) {
    if (cores.samples[s].tissue != id) continue;
    samples.push_back(cores.samples[s]);
    which.push_back(s);
  }
  const Eigen::MatrixXd worth = targets(which, Eigen::all);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(vertexCount(), targets.cols());
  if (const auto its = std::ranges::find(own, tissue, &OwnEquations::tissue); its != own.end()) {
    const FieldRegion& region = *its->ground->region;
    const Eigen::MatrixXd X = its->ground->solve(worth);
    for (std::size_t r = 0; r < region.row.size(); ++r)
      out.row(solver->pattern().vertex[static_cast<std::size_t>(region.row[r])]) =
          X.row(static_cast<Eigen::Index>(r));
    return out;
  }
  Eigen::VectorXd scale(targets.cols());
  for (Eigen::Index c = 0; c < scale.size(); ++c)
    scale[c] = std::max(targets.col(c).cwiseAbs().maxCoeff(), std::numeric_limits<double>::min());
  const SparseSides b = sidesOf(domain->mesh, solver->pattern(), samples, worth);
  FieldMatrix X = FieldMatrix::Zero(solver->pattern().rowCount(), targets.cols());
  const Refined refined = refinedSolve(*ground, b, scale, X, [&] { return run.cancelled(); });
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "cancelled while solving tissue fields");
  if (!refined.done) {
    auto whole = solver->factorise(cores, options, run);
    if (!whole) return passOn(whole);
    factor = std::move(*whole);
    return solver->solveTargets(factor, cores, tissues, tissue, targets, run);
  }
  for (Eigen::Index r = 0; r < X.rows(); ++r)
    out.row(solver->pattern().vertex[static_cast<std::size_t>(r)]) = X.row(r);
  return out;
}

// Ties as ownerOf decides them: of equal fields the tissue of lowest id wins, fat always loses.
void ValueFields::Impl::findRivals(Eigen::Index field) {
  if (rivalsOf == field) return;
  rivalsOf = field;
  lastTold = fields.values.col(field);
  rival.resize(static_cast<std::size_t>(vertexCount()));
  rivalField.resize(rival.size());
  const FieldMatrix& f = fields.values;
  parallelFor(
      vertexCount(),
      [&](std::int64_t v) {
        double best = -std::numeric_limits<double>::infinity();
        Eigen::Index who = -1;
        for (Eigen::Index j = 1; j < f.cols(); ++j) {
          if (j == field || !(f(v, j) > best)) continue;
          best = f(v, j);
          who = j;
        }
        if (field != 0 && fields.fatIsCandidate && (who < 0 || f(v, 0) > best)) {
          best = f(v, 0);
          who = 0;
        }
        rival[static_cast<std::size_t>(v)] = best;
        rivalField[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(who);
      },
      kOwnerGrain);
}

// Writes a field that was made anew, and owners with it.
ValueFields::Changed ValueFields::Impl::take(Eigen::Index field) {
  const Eigen::Index n = vertexCount();
  const bool competes = field != 0 || fields.fatIsCandidate;
  const std::int64_t chunks = (n + kOwnerGrain - 1) / kOwnerGrain;
  std::vector<Changed> parts(static_cast<std::size_t>(chunks));
  parallelFor(
      chunks,
      [&](std::int64_t chunk) {
        Changed& part = parts[static_cast<std::size_t>(chunk)];
        const double told = kTold * fields.maxValue;
        for (std::int64_t v = chunk * kOwnerGrain;
             v < std::min<std::int64_t>(n, (chunk + 1) * kOwnerGrain); ++v) {
          double& f = fields.values(v, field);
          f = corrected[v];
          if (std::abs(f - lastTold[v]) > told)
            part.vertices.push_back(static_cast<std::int32_t>(v));
          const auto k = static_cast<std::size_t>(v);
          const std::int32_t other = rivalField[k];
          bool wins = competes;
          if (other >= 0 && competes) {
            // Fat beats nobody at a tie; among tissues the lower id does
            wins = field == 0   ? f > rival[k]
                   : other == 0 ? !(rival[k] > f)
                                : f > rival[k] || (f == rival[k] && field < other);
          }
          const TissueId now(wins || other < 0 ? field + 1 : other + 1);
          if (now != owner[k]) {
            owner[k] = now;
            ++part.owners;
            if (part.vertices.empty() || part.vertices.back() != v)
              part.vertices.push_back(static_cast<std::int32_t>(v));
          }
        }
        for (const std::int32_t v : part.vertices) lastTold[v] = corrected[v];
      },
      1);
  Changed out;
  for (const Changed& part : parts) {
    out.vertices.insert(out.vertices.end(), part.vertices.begin(), part.vertices.end());
    out.owners += part.owners;
  }
  out.fields.push_back(static_cast<std::int32_t>(field));
  return out;
}

Basis& ValueFields::Impl::basisOf(std::size_t tissue) {
  EC_REQUIRE(tissue < tissues.size());
  const auto field = static_cast<Eigen::Index>(tissue) + 1;
  const auto known =
      std::ranges::find_if(ready, [&](const Basis& basis) { return basis.field == field; });
  if (known != ready.end()) {
    ready.splice(ready.begin(), ready, known);
    return ready.front();
  }
  Basis basis;
  basis.field = field;
  std::vector<std::vector<double>> values;
  std::vector<Eigen::Index> first;
  Eigen::Index points = 0;
  for (const TissueCurve& curve : tissues[tissue].curves) {
    first.push_back(points);
    points += static_cast<Eigen::Index>(curve.values.size());
    values.push_back(curve.values);
  }
  basis.D = valuesAt(values);
  basis.phi.resize(static_cast<std::size_t>(points));
  const TissueId id(field + 1);
  basis.hat = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(cores.samples.size()), points);
  for (std::size_t s = 0; s < cores.samples.size(); ++s) {
    const CoreSample& sample = cores.samples[s];
    if (sample.tissue != id) continue;
    const auto c = static_cast<std::size_t>(sample.curve);
    std::vector<double> unit(tissues[tissue].curves[c].values.size(), 0.0);
    // Values are linear in arc length between points: two of them count
    const auto left = std::min(static_cast<std::size_t>(sample.u), unit.size() - 1);
    for (std::size_t p = left; p < std::min(left + 2, unit.size()); ++p) {
      unit[p] = 1.0;
      basis.hat(static_cast<Eigen::Index>(s), first[c] + static_cast<Eigen::Index>(p)) =
          tissues[tissue].curves[c].spline.interpolate(unit, sample.u);
      unit[p] = 0.0;
    }
  }
  ready.push_front(std::move(basis));
  if (ready.size() > kReady) ready.pop_back();
  return ready.front();
}

// Gets φ of these points and the field as it stands. Where a tissue has a matrix of its own, making
// that is the work: all points come along.
Result<void> ValueFields::Impl::solveFor(Basis& basis, const std::vector<Eigen::Index>& points,
                                         RunContext& run) {
  const auto tissue = static_cast<std::size_t>(basis.field - 1);
  std::vector<Eigen::Index> wanted;
  const auto ask = [&](Eigen::Index p) {
    if (basis.phi[static_cast<std::size_t>(p)].size() == 0) wanted.push_back(p);
  };
  const bool own = !tissues[tissue].anisotropy.isIsotropic();
  if (own && basis.raw.size() == 0) {
    for (Eigen::Index p = 0; p < basis.D.size(); ++p) ask(p);
  } else {
    for (const Eigen::Index p : points) ask(p);
  }
  const bool field = basis.raw.size() == 0;
  if (wanted.empty() && !field) return {};
  Eigen::MatrixXd targets(basis.hat.rows(), std::ssize(wanted) + (field ? 1 : 0));
  for (std::size_t k = 0; k < wanted.size(); ++k)
    targets.col(static_cast<Eigen::Index>(k)) = basis.hat.col(wanted[k]);
  if (field) targets.rightCols(1) = basis.hat * basis.D;
  const auto solved = factor ? solver->solveTargets(factor, cores, tissues, tissue, targets, run)
                             : solveRows(TissueId(basis.field + 1), targets, run);
  if (!solved) return passOn(solved);
  for (std::size_t k = 0; k < wanted.size(); ++k)
    basis.phi[static_cast<std::size_t>(wanted[k])] = solved->col(static_cast<Eigen::Index>(k));
  if (field) basis.raw = solved->rightCols(1);
  return {};
}

Result<ValueFields::Changed> ValueFields::setValues(std::size_t tissue,
                                                    const std::vector<std::vector<double>>& values,
                                                    RunContext& run) {
  Impl& I = *impl_;
  EC_REQUIRE(!I.adrift);
  Basis& basis = I.basisOf(tissue);
  CurveTissue& own = I.tissues[tissue];
  EC_REQUIRE_EQ(values.size(), own.curves.size());
  for (std::size_t c = 0; c < values.size(); ++c)
    EC_REQUIRE_EQ(values[c].size(), own.curves[c].values.size());
  const Eigen::VectorXd D = valuesAt(values);
  const Step step = stepTo(basis.D, D);
  if (auto ready = I.solveFor(basis, step.moved, run); !ready) return passOn(ready);
  I.findRivals(basis.field);
  for (std::size_t c = 0; c < values.size(); ++c) own.curves[c].values = values[c];
  I.fields.maxValue = I.options.fat;
  for (const CurveTissue& t : I.tissues)
    I.fields.maxValue = std::max(I.fields.maxValue, t.largestValue());

  // f = Σ_p D_p φ_p, then what linear tets make wrong of it near curves
  const Eigen::Index n = I.vertexCount();
  parallelFor((n + kOwnerGrain - 1) / kOwnerGrain,
              [&](std::int64_t chunk) {
                const Eigen::Index begin = chunk * kOwnerGrain;
                const Eigen::Index count = std::min<Eigen::Index>(kOwnerGrain, n - begin);
                auto raw = basis.raw.segment(begin, count);
                if (step.scale != 1.0) raw *= step.scale;
                for (const Eigen::Index k : step.moved)
                  raw += (D[k] - step.scale * basis.D[k]) *
                         basis.phi[static_cast<std::size_t>(k)].segment(begin, count);
              },
              1);
  basis.D = D;
  const Eigen::VectorXd target = basis.hat * D;
  I.corrected = basis.raw;
  I.keepUncorrected(basis.field, basis.raw);
  correctNearCurves(*I.domain, I.cores, target, TissueId(basis.field + 1), I.corrected);
  return I.take(basis.field);
}

ValueFields::Changed ValueFields::setFat(double fat) {
  EC_REQUIRE(fat >= 0.0);
  Impl& I = *impl_;
  EC_REQUIRE(!I.adrift);
  if (!I.phiFat) I.phiFat = I.solver->solveFat(I.factor, I.cores);
  I.options.fat = fat;
  I.fields.fatIsCandidate = fat > 0.0;
  I.fields.maxValue = fat;
  for (const CurveTissue& t : I.tissues)
    I.fields.maxValue = std::max(I.fields.maxValue, t.largestValue());
  I.findRivals(0);
  const Eigen::VectorXd target =
      Eigen::VectorXd::Zero(static_cast<Eigen::Index>(I.cores.samples.size()));
  I.corrected = fat * I.phiFat->col(0);
  I.keepUncorrected(0, I.corrected);
  correctNearCurves(*I.domain, I.cores, target, kFat, I.corrected);
  return I.take(0);
}

void ValueFields::Impl::keepUncorrected(Eigen::Index field, const Eigen::VectorXd& raw) {
  moving.reset();  // it stands on what was settled before
  UncorrectedRows& rows = fields.uncorrected;
  for (std::size_t k = 0; k < rows.vertex.size(); ++k)
    rows.values(static_cast<Eigen::Index>(k), field) = raw[rows.vertex[k]];
}

// What every move stands on.
void ValueFields::Impl::stand() {
  if (!walker) walker = std::make_shared<const CurveWalker>(*domain);
  if (!ground) ground = std::make_shared<DragGround>(solver, factor, cores);
}

MovedFields::Told ValueFields::Impl::begin(std::vector<CurveRef> curves) {
  stand();
  if (!adrift) settled = tissues;
  MovedFields::Told back;
  if (moving) back = moving->restore();
  moving = std::make_unique<MovedFields>(*domain, DragGrounds{ground, own}, *walker, cores, settled,
                                         options, std::move(curves), fields, owner);
  return back;
}

bool ValueFields::isAdrift() const { return impl_->adrift; }

void ValueFields::prepareMove(const std::vector<CurveRef>& curves) {
  Impl& I = *impl_;
  if (!I.stands() || I.adrift || (I.moving && I.moving->moved() == curves)) return;
  I.stand();
  if (!curves.empty()) (void)I.begin(curves);
}

ValueFields::Changed ValueFields::moveCurves(const std::vector<CurveMove>& moves) {
  Impl& I = *impl_;
  if (moves.empty() || !I.stands()) return {};
  std::vector<CurveRef> wanted;
  if (I.moving) wanted = I.moving->moved();
  bool anew = !I.moving;
  for (const CurveMove& move : moves) {
    if (std::ranges::find(wanted, move.curve) != wanted.end()) continue;
    // Only prepared so far: nobody has moved those curves
    if (!I.adrift && !anew) wanted.clear();
    wanted.push_back(move.curve);
    anew = true;
  }
  MovedFields::Told back;
  if (anew) back = I.begin(std::move(wanted));
  for (const CurveMove& move : moves) {
    I.tissues[move.curve.tissue].curves[static_cast<std::size_t>(move.curve.curve)].spline =
        move.spline;
  }
  std::vector<mesh::Spline> splines;
  for (const CurveRef& ref : I.moving->moved())
    splines.push_back(I.tissues[ref.tissue].curves[static_cast<std::size_t>(ref.curve)].spline);
  I.adrift = true;
  I.rivalsOf = -1;
  I.ready.clear();
  MovedFields::Told told = I.moving->move(splines);
  Changed out{{}, told.owners, {}, told.error};
  std::ranges::set_union(told.vertices, back.vertices, std::back_inserter(out.vertices));
  std::ranges::set_union(told.fields, back.fields, std::back_inserter(out.fields));
  return out;
}

}  // namespace ecorche::tissue
