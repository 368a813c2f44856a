#include <ecorche/core/parallel.h>
#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/settled_store.h>
#include <ecorche/tissue/settling.h>
#include <ecorche/tissue/value_fields.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "support/cases.h"
#include "support/generated_domain.h"
#include "tissue/curves.h"

using namespace ecorche;
using namespace ecorche::tissue;
using mesh::Vector3;
using test::muscle;

namespace {

// A limb without bones that a hand edits, and what it takes to solve for it from scratch.
struct Limb {
  std::shared_ptr<const domain::Domain> domain;
  std::shared_ptr<const TissueSolver> solver;
  CurveWalker walker;
  TissueOptions options;
  RunContext run;
  std::vector<CurveTissue> list;
  int named = 0;
  std::mt19937_64 random;

  explicit Limb(std::uint64_t seed)
      : domain(std::make_shared<const domain::Domain>(
            test::cylinderDomain(1.0, 2.0, 9 + int(seed % 5), 9))),
        walker(*domain),
        random(seed) {
    options.fat = 0.3;
    solver =
        std::make_shared<const TissueSolver>(std::move(TissueSolver::create(*domain, run).value()));
    for (int i = 0; i < 3; ++i) list.push_back(drawn());
  }
  double uniform(double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  }
  std::size_t below(std::size_t count) { return random() % count; }
  Vector3 place(double z) { return {uniform(-0.5, 0.5), uniform(-0.5, 0.5), z}; }
  CurveTissue drawn() {
    std::vector<Vector3> points;
    const auto count = 2 + below(3);
    for (std::size_t k = 0; k < count; ++k)
      points.push_back(place(0.2 + 1.6 * double(k) / double(count - 1)));
    return muscle("muscle " + std::to_string(++named), points, uniform(0.4, 1.5));
  }
  [[nodiscard]] CoreSamples cores() {
    return traceCurves(walker, *domain, list, options, run).value();
  }
  [[nodiscard]] TissueFields anew() { return solver->solve(cores(), list, options, run).value(); }

  // Any of the edits that a hand makes
  void edit() {
    CurveTissue& tissue = list[below(list.size())];
    TissueCurve& curve = tissue.curves[below(tissue.curves.size())];
    auto points = curve.spline.points();
    const auto at = below(points.size());
    switch (below(9)) {
      case 8: {
        const bool isotropic = !tissue.anisotropy.isIsotropic() && below(2) == 0;
        tissue.anisotropy = isotropic
                                ? Anisotropy{}
                                : Anisotropy{std::pow(10.0, uniform(-1.0, 1.0)),
                                             std::pow(10.0, uniform(-1.0, 1.0)), uniform(0.0, 3.0)};
        return;
      }
      case 0:
        curve.values[at] = uniform(0.2, 2.0);
        return;
      case 1:
        options.fat = below(4) == 0 ? 0.0 : uniform(0.1, 0.6);
        return;
      case 2:
      case 3:
        points[at] = place(points[at].z() + uniform(-0.1, 0.1));
        break;
      case 4:
        if (points.size() > 6) return;
        points.insert(points.begin() + std::ptrdiff_t(at) + 1,
                      place(points[at].z() + uniform(0.02, 0.1)));
        curve.values.insert(curve.values.begin() + std::ptrdiff_t(at) + 1, uniform(0.4, 1.5));
        break;
      case 5:
        if (points.size() < 3) return;
        points.erase(points.begin() + std::ptrdiff_t(at));
        curve.values.erase(curve.values.begin() + std::ptrdiff_t(at));
        break;
      case 6:
        if (below(2) == 0) {
          tissue.curves.push_back(drawn().curves[0]);
        } else {
          list.insert(list.begin() + std::ptrdiff_t(below(list.size())), drawn());
        }
        return;
      default:
        if (tissue.curves.size() > 1) {
          tissue.curves.pop_back();
        } else if (list.size() > 1) {
          list.erase(list.begin() + (&tissue - list.data()));
        }
        return;
    }
    curve.spline = mesh::Spline(points);
  }
};

// Owners are the same but where the two largest fields are as good as equal
void checkOwners(const TissueFields& a, const TissueFields& b) {
  const auto ownersA = vertexOwners(a);
  const auto ownersB = vertexOwners(b);
  for (std::size_t v = 0; v < ownersA.size(); ++v) {
    if (ownersA[v] == ownersB[v]) continue;
    auto row = b.values.row(Eigen::Index(v));
    CHECK(std::abs(row[ownersA[v].value - 1] - row[ownersB[v].value - 1]) < 1e-8 * b.maxValue);
  }
}

// With curves all along it: none is felt at the other end
struct LongLimb {
  domain::Domain domain = test::cylinderDomain(0.5, 12.0, 6, 48);
  RunContext run;
  std::shared_ptr<const TissueSolver> solver =
      std::make_shared<const TissueSolver>(std::move(TissueSolver::create(domain, run).value()));
  std::vector<CurveTissue> list;
  Settling settling{solver};

  LongLimb() {
    for (int i = 0; i < 6; ++i)
      list.push_back(muscle("muscle " + std::to_string(i),
                            {{0.1, 0.1, 2.0 * i + 0.3}, {-0.1, 0.1, 2.0 * i + 1.7}}));
  }
  // Looks whether it is what a solve from scratch gives
  Settling::Settled settle() {
    const TissueOptions options;
    const CoreSamples cores = traceCurves(domain, list, options, run).value();
    auto settled = settling.solve(cores, list, options, run).value();
    const TissueFields fresh = solver->solve(cores, list, options, run).value();
    CHECK((settled.fields.values - fresh.values).cwiseAbs().maxCoeff() < 1e-8 * fresh.maxValue);
    return settled;
  }
};

}  // namespace

TEST_CASE("any hundred edits end in the fields of a solve from scratch") {
  for (const std::uint64_t seed : test::casesHere(12)) {
    INFO("seed " << seed);
    Limb limb(seed + 1);
    Settling settling(limb.solver);
    int fromBefore = 0;
    for (int step = 0; step < 100; ++step) {
      INFO("step " << step);
      limb.edit();
      const auto settled = settling.solve(limb.cores(), limb.list, limb.options, limb.run);
      REQUIRE(settled);
      REQUIRE(settled->ground);
      fromBefore += settled->factored < 1.0;
      if (step % 10 != 9) continue;
      const TissueFields fresh = limb.anew();
      CHECK((settled->fields.values - fresh.values).cwiseAbs().maxCoeff() < 1e-8 * fresh.maxValue);
      CHECK((settled->fields.uncorrected.values - fresh.uncorrected.values).cwiseAbs().maxCoeff() <
            1e-8 * fresh.maxValue);
      CHECK(settled->fields.uncorrected.vertex == fresh.uncorrected.vertex);
      CHECK(settled->fields.fatIsCandidate == fresh.fatIsCandidate);
      CHECK(settled->fields.maxValue == fresh.maxValue);
      checkOwners(settled->fields, fresh);
    }
    CHECK(fromBefore > 20);
  }
}

TEST_CASE("what has been settled answers edits of values and fat, and moves") {
  const bool anisotropic = GENERATE(false, true);
  INFO("anisotropic " << anisotropic);
  Limb limb(3);
  if (anisotropic) limb.list[0].anisotropy = {1.3, 0.8, 0.4};
  if (anisotropic) limb.list[1].anisotropy = {0.2, 0.5, 0.4};
  Settling settling(limb.solver);
  const auto make = [&] {
    return ValueFields::create(limb.domain, settling, limb.cores(), limb.list, limb.options,
                               limb.run)
        .value();
  };
  (void)make();
  limb.list[0].curves[0].spline = mesh::Spline({{0.2, 0.1, 0.2}, {0.3, 0.2, 1.0}, {0.1, 0.2, 1.7}});
  limb.list[0].curves[0].values = {1.0, 0.8, 0.9};
  ValueFields fields = make();

  limb.list[0].curves[0].values = {1.0, 1.3, 0.9};
  REQUIRE(fields.setValues(0, {limb.list[0].curves[0].values}, limb.run));
  limb.options.fat = 0.5;
  (void)fields.setFat(0.5);
  const TissueFields fresh = limb.anew();
  CHECK((fields.fields().values - fresh.values).cwiseAbs().maxCoeff() < 1e-8 * fresh.maxValue);
  checkOwners(fields.fields(), fresh);

  auto points = limb.list[0].curves[0].spline.points();
  points[1] += Vector3(0.05, -0.1, 0.05);
  limb.list[0].curves[0].spline = mesh::Spline(points);
  const auto moved = fields.moveCurves({{{0, 0}, limb.list[0].curves[0].spline}});
  CHECK_FALSE(moved.vertices.empty());
  const TissueFields after = limb.anew();
  // The medium of a moved tissue is the one that was settled
  CHECK((fields.fields().values - after.values).cwiseAbs().maxCoeff() <
        (anisotropic ? 0.1 : 0.03) * after.maxValue);
  const ValueFields settled = make();
  CHECK((settled.fields().values - after.values).cwiseAbs().maxCoeff() < 1e-8 * after.maxValue);
}

TEST_CASE("an undo finds what was settled, to the last bit, and drags go on from there") {
  for (const std::uint64_t seed : test::casesHere(4)) {
    INFO("seed " << seed);
    Limb limb(seed + 7);
    Settling settling(limb.solver);
    SettledStore store(std::size_t{1} << 30);
    struct Step {
      std::vector<CurveTissue> list;
      TissueOptions options;
      FieldMatrix values;
    };
    std::vector<Step> past;
    for (int step = 0; step < 12; ++step) {
      limb.edit();
      if (store.find(limb.list, limb.options) != nullptr) continue;
      const auto settled = std::make_shared<const Settling::Settled>(
          settling.solve(limb.cores(), limb.list, limb.options, limb.run).value());
      store.keep(limb.list, limb.options, settled);
      past.push_back({limb.list, limb.options, settled->fields.values});
    }
    CHECK(past.size() > 6);
    for (auto step = past.rbegin(); step != past.rend(); ++step) {
      const SettledStore::Result found = store.find(step->list, step->options);
      REQUIRE(found);
      CHECK(found->fields.values == step->values);
      limb.list = step->list;
      limb.options = step->options;
      ValueFields fields = ValueFields::create(limb.domain, limb.solver, *found, limb.cores(),
                                               limb.list, limb.options);
      auto points = limb.list[0].curves[0].spline.points();
      points[0] += Vector3(0.03, -0.03, 0.02);
      (void)fields.moveCurves({{{0, 0}, mesh::Spline(points)}});
      CHECK(store.find(step->list, step->options)->fields.values == step->values);
      CHECK(fields.fields().values != step->values);
    }
  }
}

TEST_CASE("a store of settled results keeps to its bytes and drops what nobody has asked for") {
  Limb limb(2);
  Settling settling(limb.solver);
  const auto settle = [&] {
    return std::make_shared<const Settling::Settled>(
        settling.solve(limb.cores(), limb.list, limb.options, limb.run).value());
  };
  const auto first = settle();
  const std::size_t size = [&] {
    SettledStore alone(std::size_t{1} << 30);
    alone.keep(limb.list, limb.options, first);
    return alone.bytes();
  }();
  CHECK(size > sizeof(double) * std::size_t(first->fields.values.size()));
  SettledStore none(size - 1);
  none.keep(limb.list, limb.options, first);
  CHECK(none.size() == 0);

  // The same equations and factor for all of them: only fields are added
  SettledStore store(size + size / 2);
  const TissueOptions begin = limb.options;
  store.keep(limb.list, begin, first);
  std::size_t kept = 1;
  for (int k = 1; k < 60; ++k) {
    limb.options.fat = 0.3 + 0.005 * k;
    const auto settled = settle();
    CHECK(settled->factored == 0.0);
    CHECK(store.find(limb.list, begin) != nullptr);
    store.keep(limb.list, limb.options, settled);
    CHECK(store.bytes() <= size + size / 2);
    kept = std::max(kept, store.size());
  }
  CHECK(kept >= 2);
  CHECK(store.size() < 60);
  CHECK(store.find(limb.list, limb.options) != nullptr);
  limb.options.fat = 0.305;
  CHECK(store.find(limb.list, limb.options) == nullptr);
  limb.options.fat = 0.3;
  limb.list[0].curves[0].values[0] *= 1.0 + 1e-15;
  CHECK(store.find(limb.list, limb.options) == nullptr);
}

TEST_CASE("anisotropic tissues come and go, and nothing else is forgotten") {
  Limb limb(4);
  Settling settling(limb.solver);
  REQUIRE(settling.solve(limb.cores(), limb.list, limb.options, limb.run)->own.empty());
  const auto isotropic = limb.list;
  limb.list[1].anisotropy.lambda2 = 3.0;
  const auto own = settling.solve(limb.cores(), limb.list, limb.options, limb.run);
  REQUIRE(own);
  REQUIRE(own->ground);
  REQUIRE(own->own.size() == 1);
  CHECK(own->own[0].tissue == 1);
  const auto same = settling.solve(limb.cores(), limb.list, limb.options, limb.run);
  CHECK(same->own[0].ground == own->own[0].ground);
  limb.list = isotropic;
  const auto again = settling.solve(limb.cores(), limb.list, limb.options, limb.run);
  REQUIRE(again->ground);
  CHECK(again->own.empty());
  CHECK(again->factored == 0.0);
}

TEST_CASE("an anisotropic field is solved for where it is something") {
  LongLimb limb;
  std::vector<CurveTissue>& list = limb.list;
  list[0].anisotropy = {0.3, 2.0, 0.5};
  list[3].anisotropy = {4.0, 0.5, 0.0};
  const auto first = limb.settle().own;
  REQUIRE(first.size() == 2);
  for (const OwnEquations& own : first) {
    CHECK_FALSE(own.ground->region->isWhole());
    CHECK(own.ground->ground->pattern->rowCount() < 0.8 * limb.solver->pattern().rowCount());
  }
  // A far curve is none of its business, a near one is
  list[5].curves[0].spline = mesh::Spline({{0.2, 0.0, 10.4}, {-0.1, 0.1, 11.6}});
  const auto far = limb.settle().own;
  CHECK(far[0].ground == first[0].ground);
  list[1].curves[0].spline = mesh::Spline({{0.2, 0.0, 2.4}, {-0.1, 0.1, 3.6}});
  const auto near = limb.settle().own;
  CHECK(near[0].ground != first[0].ground);
  CHECK(near[0].ground->region == first[0].ground->region);
  // Out of its region, it is given another
  list[0].curves[0].spline = mesh::Spline({{0.1, 0.1, 8.3}, {-0.1, 0.1, 9.5}});
  const auto away = limb.settle().own;
  CHECK(away[0].ground->region != first[0].ground->region);
}

TEST_CASE("fields that edits hardly change are left alone, and stay right for all that") {
  LongLimb limb;
  int leftOut = 0;
  int inARow = 0;
  int mostInARow = 0;
  for (int edit = 0; edit < 30; ++edit) {
    INFO("edit " << edit);
    limb.list[0].curves[0].spline =
        mesh::Spline({{0.1, 0.1, 0.3}, {-0.1 + 0.005 * (edit % 7), 0.1, 1.7}});
    const bool some = limb.settle().leftOut > 0;
    leftOut += some ? 1 : 0;
    inARow = some ? inARow + 1 : 0;
    mostInARow = std::max(mostInARow, inARow);
  }
  CHECK(leftOut >= 20);
  CHECK(mostInARow == 8);
}

TEST_CASE("an anisotropic curve may end in a tet that has nothing but skin around it") {
  // A pleat of the skin that reaches one vertex further in
  domain::Domain pleated = test::cylinderDomain(1.0, 2.0, 9, 9);
  const mesh::TetMesh& mesh = pleated.mesh;
  const auto skinCorners = [&](Eigen::Index t) {
    int count = 0;
    for (int k = 0; k < 4; ++k) count += pleated.onSkin[std::size_t(mesh.T(t, k))] != 0;
    return count;
  };
  Eigen::Index pleat = 0;
  while (skinCorners(pleat) != 3) ++pleat;
  for (int k = 0; k < 4; ++k) pleated.onSkin[std::size_t(mesh.T(pleat, k))] = 1;
  const Vector3 end = mesh.V(mesh.T.row(pleat), Eigen::all).colwise().mean();

  const auto domain = std::make_shared<const domain::Domain>(pleated);
  RunContext run;
  const TissueOptions options;
  const auto solver =
      std::make_shared<const TissueSolver>(std::move(TissueSolver::create(*domain, run).value()));
  std::vector<CurveTissue> list{muscle("plain", {{0.3, 0.3, 0.5}, {0.3, 0.2, 1.5}}),
                                muscle("from the pleat", {end, {0.0, 0.0, 1.0}})};
  list[1].anisotropy = {0.4, 2.0, 0.1};
  const CoreSamples cores = traceCurves(*domain, list, options, run).value();
  REQUIRE(std::ranges::any_of(cores.samples,
                              [&](const CoreSample& s) { return skinCorners(s.tet) == 4; }));
  const auto off = [&](const ValueFields& fields) {
    const TissueFields fresh = solver->solve(cores, list, options, run).value();
    return (fields.fields().values - fresh.values).cwiseAbs().maxCoeff() / fresh.maxValue;
  };
  Settling settling(solver);
  auto fields = ValueFields::create(domain, settling, cores, list, options, run);
  REQUIRE(fields);
  CHECK(off(*fields) < 1e-8);
  list[1].curves[0].values = {1.0, 1.3};
  REQUIRE(fields->setValues(1, {list[1].curves[0].values}, run));
  CHECK(off(*fields) < 1e-8);
}

TEST_CASE("a cancelled solve leaves what was settled before") {
  Limb limb(5);
  Settling settling(limb.solver);
  REQUIRE(settling.solve(limb.cores(), limb.list, limb.options, limb.run));
  const auto before = limb.list;
  limb.edit();
  RunContext stopped;
  stopped.cancel();
  const auto none = settling.solve(limb.cores(), limb.list, limb.options, stopped);
  REQUIRE_FALSE(none);
  CHECK(none.error().code == ErrorCode::Cancelled);
  limb.list = before;
  CHECK(settling.solve(limb.cores(), limb.list, limb.options, limb.run)->factored == 0.0);
}

TEST_CASE("the same edits give the same bytes on any number of threads") {
  const auto last = [](int threads) {
    const ThreadLimit limit(threads);
    Limb limb(6);
    Settling settling(limb.solver);
    FieldMatrix out;
    for (int step = 0; step < 20; ++step) {
      limb.edit();
      out = settling.solve(limb.cores(), limb.list, limb.options, limb.run)->fields.values;
    }
    return out;
  };
  CHECK(last(1) == last(2));
}
