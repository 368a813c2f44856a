#include <ecorche/tissue/curve_trace.h>
#include <ecorche/tissue/segmentation.h>
#include <ecorche/tissue/target_volume.h>
#include <ecorche/tissue/value_fields.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "support/generated_domain.h"
#include "tissue/curves.h"

using namespace ecorche;
using namespace ecorche::tissue;
using test::muscle;

namespace {

// Two heads, an anisotropic one, a filler, and more than are kept ready
std::vector<CurveTissue> sixTissues() {
  CurveTissue biceps = muscle("biceps", {{0.5, 0.1, 0.1}, {0.6, 0.0, 1.0}, {0.4, -0.1, 1.9}}, 1.2);
  biceps.curves.push_back(
      muscle("", {{0.3, 0.4, 0.1}, {0.45, 0.3, 1.0}, {0.4, 0.0, 1.8}}).curves[0]);
  CurveTissue triceps = muscle("triceps", {{-0.5, 0.1, 0.1}, {-0.6, -0.1, 1.0}, {-0.4, 0.1, 1.9}});
  triceps.anisotropy = {1.0, 0.4, 0.3};
  CurveTissue filler = muscle("belly", {{0.0, -0.5, 0.5}, {0.0, -0.5, 1.5}});
  filler.filler = true;
  return {biceps,
          triceps,
          filler,
          muscle("a", {{0.1, 0.6, 0.2}, {0.0, 0.6, 1.8}}),
          muscle("b", {{-0.3, 0.5, 0.2}, {-0.2, 0.3, 1.0}, {-0.3, 0.4, 1.8}}, 0.7),
          muscle("c", {{0.4, -0.5, 0.2}, {0.4, -0.6, 1.8}}, 0.8)};
}

// Owners differ only where the two largest fields are as good as equal
std::int64_t wrongOwners(const ValueFields& edited, const TissueFields& fresh) {
  const auto expected = vertexOwners(fresh);
  std::int64_t wrong = 0;
  for (std::size_t v = 0; v < expected.size(); ++v) {
    if (edited.owners()[v] == expected[v]) continue;
    const auto f = fresh.values.row(static_cast<Eigen::Index>(v));
    const double gap = std::abs(f[edited.owners()[v].value - 1] - f[expected[v].value - 1]);
    wrong += gap > 1e-9 * fresh.maxValue;
  }
  return wrong;
}

}  // namespace

TEST_CASE("fields after any edits of values and fat are those of a solve from scratch") {
  const std::uint64_t seed = GENERATE(1u, 2u, 3u);
  INFO("seed " << seed);
  std::mt19937_64 random(seed);
  const auto between = [&](double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
  };
  const auto domain =
      std::make_shared<const domain::Domain>(test::cylinderDomain(1.0, 2.0, 12, 18));
  RunContext run;
  auto list = sixTissues();
  TissueOptions options;
  options.fat = seed == 2 ? 0.0 : 0.3;
  const auto solver =
      std::make_shared<const TissueSolver>(std::move(TissueSolver::create(*domain, run).value()));
  const auto cores = traceCurves(*domain, list, options, run).value();
  auto edited = ValueFields::create(domain, solver, cores, list, options, run).value();
  CHECK((edited.fields().values - solver->solve(cores, list, options, run)->values)
            .cwiseAbs()
            .maxCoeff() == 0.0);

  // What somebody has who only looks where he is told to
  FieldMatrix seen = edited.fields().values;
  Eigen::Index lastField = -1;
  int turns = 1;  // from one field to another: what was too little to be told stays so
  for (int edit = 0; edit < 60; ++edit) {
    const FieldMatrix before = edited.fields().values;
    const auto ownersBefore = edited.owners();
    ValueFields::Changed changed;
    Eigen::Index field = 0;
    if (edit % 7 == 3) {
      options.fat = edit % 14 == 3 ? between(0.0, 0.8) : 0.0;
      changed = edited.setFat(options.fat);
    } else {
      const std::size_t t = random() % list.size();
      field = static_cast<Eigen::Index>(t) + 1;
      // One point of each curve, or the muscle as a whole, or the whole and a point
      std::vector<std::vector<double>> values;
      const double factor = edit % 3 == 0 ? 1.0 : between(0.7, 1.4);
      for (TissueCurve& curve : list[t].curves) {
        for (double& value : curve.values) value *= factor;
        if (edit % 3 != 1) curve.values[random() % curve.values.size()] = between(0.05, 3.0);
        values.push_back(curve.values);
      }
      changed = edited.setValues(t, values, run).value();
    }
    turns += field != lastField;
    lastField = field;
    for (const std::int32_t v : changed.vertices) seen(v, field) = edited.fields().values(v, field);
    CHECK((seen - edited.fields().values).cwiseAbs().maxCoeff() <=
          turns * ValueFields::kTold * 3.1);
    std::int64_t owners = 0;
    for (std::size_t v = 0; v < ownersBefore.size(); ++v) {
      const bool other = edited.owners()[v] != ownersBefore[v];
      owners += other;
      if (other) CHECK(std::ranges::binary_search(changed.vertices, static_cast<std::int32_t>(v)));
    }
    CHECK(owners == changed.owners);
    for (Eigen::Index j = 0; j < before.cols(); ++j) {
      if (j != field) CHECK(edited.fields().values.col(j) == before.col(j));
    }
    if (edit % 6 != 5) continue;
    const TissueFields fresh = solver->solve(cores, list, options, run).value();
    CHECK(edited.fields().maxValue == fresh.maxValue);
    CHECK(edited.fields().fatIsCandidate == fresh.fatIsCandidate);
    CHECK((edited.fields().values - fresh.values).cwiseAbs().maxCoeff() < 1e-10 * fresh.maxValue);
    CHECK(wrongOwners(edited, fresh) == 0);
  }
}

TEST_CASE("equal fields are owned as everywhere else") {
  // Two muscles on one curve: the first in the list wins while they are equal
  const auto domain = std::make_shared<const domain::Domain>(test::cylinderDomain(1.0, 2.0, 8, 12));
  RunContext run;
  const std::vector<CurveTissue> list = {muscle("first", {{0.2, 0, 0.2}, {0.2, 0, 1.8}}),
                                         muscle("second", {{0.2, 0, 0.2}, {0.2, 0, 1.8}}, 0.5)};
  const TissueOptions options{.fat = 0.0};
  const auto solver =
      std::make_shared<const TissueSolver>(std::move(TissueSolver::create(*domain, run).value()));
  const auto cores = traceCurves(*domain, list, options, run).value();
  auto edited = ValueFields::create(domain, solver, cores, list, options, run).value();
  REQUIRE(edited.setValues(1, {{1.0, 1.0}}, run));
  CHECK(edited.owners() == vertexOwners(edited.fields()));
  REQUIRE(edited.setValues(0, {{0.4, 0.4}}, run));
  CHECK(edited.owners() == vertexOwners(edited.fields()));
  const auto free = std::ranges::count(domain->onSkin, 0);
  CHECK(std::ranges::count(edited.owners(), TissueId(3)) >= free / 2);
}

TEST_CASE("a cancelled touch changes nothing") {
  const auto domain = std::make_shared<const domain::Domain>(test::cylinderDomain(1.0, 2.0, 8, 12));
  RunContext run;
  const auto list = sixTissues();
  const auto solver =
      std::make_shared<const TissueSolver>(std::move(TissueSolver::create(*domain, run).value()));
  const auto cores = traceCurves(*domain, list, {}, run).value();
  auto edited = ValueFields::create(domain, solver, cores, list, {}, run).value();
  const FieldMatrix before = edited.fields().values;
  RunContext stopped;
  stopped.cancel();
  const auto failed = edited.setValues(3, {{2.0, 2.0}}, stopped);
  REQUIRE_FALSE(failed);
  CHECK(failed.error().code == ErrorCode::Cancelled);
  CHECK(edited.fields().values == before);
}

TEST_CASE("one tissue's volume is that of all tissues' volumes") {
  const auto domain =
      std::make_shared<const domain::Domain>(test::cylinderDomain(1.0, 2.0, 10, 15));
  for (const double fat : {0.0, 0.3}) {
    RunContext run;
    const TissueOptions options{.fat = fat};
    const auto list = sixTissues();
    const auto cores = traceCurves(*domain, list, options, run).value();
    const auto fields = solveTissueFields(*domain, cores, list, options, run).value();
    const auto all = tissueVolumes(domain->mesh, fields);
    const auto owner = vertexOwners(fields);
    for (std::size_t i = 0; i < all.size(); ++i) {
      CHECK(tissueVolume(domain->mesh, fields, owner, TissueId(static_cast<std::int64_t>(i) + 1)) ==
            Approx(all[i]).epsilon(1e-12).margin(1e-15));
    }
  }
}

TEST_CASE("a tissue gets the volume that is asked for, or a sentence says what it can have") {
  const auto domain =
      std::make_shared<const domain::Domain>(test::cylinderDomain(1.0, 2.0, 10, 15));
  RunContext run;
  const auto list = sixTissues();
  const auto solver =
      std::make_shared<const TissueSolver>(std::move(TissueSolver::create(*domain, run).value()));
  const auto cores = traceCurves(*domain, list, {}, run).value();
  auto fields = ValueFields::create(domain, solver, cores, list, {}, run).value();
  for (const std::size_t tissue : {0u, 1u, 4u}) {
    const FieldMatrix before = fields.fields().values;
    const double now = volumeOf(fields, tissue);
    for (const double factor : {0.5, 1.0, 1.4}) {
      const auto values = valuesForVolume(fields, tissue, factor * now, run);
      REQUIRE(values);
      CHECK((fields.fields().values - before).cwiseAbs().maxCoeff() < 1e-12);
      REQUIRE(fields.setValues(tissue, *values, run));
      CHECK(volumeOf(fields, tissue) == Approx(factor * now).epsilon(1e-3));
      // One factor for all points
      const double scale = (*values)[0][0] / list[tissue].curves[0].values[0];
      for (std::size_t c = 0; c < values->size(); ++c) {
        for (std::size_t p = 0; p < (*values)[c].size(); ++p)
          CHECK((*values)[c][p] == Approx(scale * list[tissue].curves[c].values[p]));
      }
      std::vector<std::vector<double>> back;
      for (const TissueCurve& curve : list[tissue].curves) back.push_back(curve.values);
      REQUIRE(fields.setValues(tissue, back, run));
    }
    const auto tooMuch = valuesForVolume(fields, tissue, 2.0 * domain->volume, run);
    REQUIRE_FALSE(tooMuch);
    CHECK(tooMuch.error().code == ErrorCode::ValueOutOfRange);
    CHECK_THAT(tooMuch.error().message, Catch::Contains(list[tissue].name));
  }
}
