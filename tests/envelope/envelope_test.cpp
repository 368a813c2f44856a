#include <ecorche/core/parallel.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/mesh/orientation.h>
#include <ecorche/mesh/surface_mesh.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <iostream>
#include <map>

#include "anatomy_faults.h"
#include "support/cases.h"
#include "support/generated_anatomy.h"
#include "support/generated_domain.h"

using namespace ecorche;
using test::FieldKind;
using test::Shape;

namespace {

constexpr std::uint64_t kSeeds = 252;  // four times every shape with every kind of fields

envelope::EnvelopeOptions plain(const tissue::TissueFields& fields) {
  return {.fatIsCandidate = fields.fatIsCandidate, .strikeIslands = false};
}

tissue::CoreSamples noCurves() { return {}; }

std::map<domain::BoundaryTag, double> areas(const mesh::Positions& V, const mesh::Triangles& F,
                                            const std::vector<domain::BoundaryTag>& tag) {
  std::map<domain::BoundaryTag, double> area;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    area[tag[static_cast<std::size_t>(f)]] += mesh::surfaceArea(V, F.row(f));
  }
  return area;
}

}  // namespace

TEST_CASE("generated anatomies are cut into conforming, positive tets that fill the domain") {
  std::int64_t tets = 0;
  std::int64_t repaired = 0;
  std::int64_t rounded = 0;
  for (const std::uint64_t seed : test::casesHere(kSeeds)) {
    const test::GeneratedAnatomy c = test::generatedAnatomy(seed);
    INFO(c.name);
    RunContext run;
    const auto build = envelope::buildAnatomy(c.domain, c.fields, noCurves(), plain(c.fields), run);
    REQUIRE(build);
    const envelope::Anatomy& a = build->anatomy;

    // Faces: each shared by two or on the boundary, found anew from the tets alone
    const auto adjacency = mesh::tetAdjacency(a.mesh.T);
    CHECK(adjacency.nonManifoldFaces == 0);
    CHECK(adjacency.neighbours == a.neighbours);
    const auto boundary = mesh::tetBoundary(a.mesh.T, a.neighbours);
    CHECK(boundary.F.rows() == a.boundaryF.rows());
    const auto before = areas(c.domain.mesh.V, c.domain.boundaryF, c.domain.boundaryTag);
    const auto after = areas(a.mesh.V, a.boundaryF, a.boundaryTag);
    CHECK(before.size() == after.size());
    for (const auto& [tag, area] : before) CHECK(after.at(tag) == Approx(area).epsilon(1e-9));

    // Volume: positive to the last bit, none lost
    std::int64_t wrong = 0;
    for (Eigen::Index t = 0; t < a.mesh.T.rows(); ++t) wrong += mesh::orientation(a.mesh, t) <= 0;
    CHECK(wrong == 0);
    CHECK(wrong == build->stats.nonPositiveTets);
    CHECK(std::abs(mesh::signedVolumes(a.mesh).sum() - c.domain.volume) <= 1e-12 * c.domain.volume);

    // Labels: the largest field owns, but for what was moved
    CHECK(build->stats.unexplainedOffLabelTets == 0);
    CHECK(test::brokenLinks(a.mesh.T, a.mesh.V.rows(), a.label) == 0);

    // What has one owner is as it was
    CHECK(a.mesh.V.topRows(c.domain.mesh.V.rows()) == c.domain.mesh.V);
    tets += a.mesh.T.rows();
    repaired += build->stats.repairedVertices;
    rounded += build->stats.nonPositiveRounded;
  }
  std::cout << "envelope: " << tets << " tets, " << repaired << " vertices repaired, " << rounded
            << " tets without volume at 32 bits\n";
}

TEST_CASE("a tet with one owner is left alone, with its corners in their order") {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const test::GeneratedAnatomy c = test::generatedAnatomy(seed);
    INFO(c.name);
    RunContext run;
    const auto cut = envelope::computeEnvelope(c.domain.mesh, c.domain.neighbours, c.fields.values,
                                               plain(c.fields), run);
    REQUIRE(cut);
    std::int64_t whole = 0;
    for (Eigen::Index t = 0; t < c.domain.mesh.T.rows(); ++t) {
      const std::int32_t first = cut->firstChild[static_cast<std::size_t>(t)];
      if (cut->firstChild[static_cast<std::size_t>(t) + 1] - first != 1) continue;
      ++whole;
      CHECK(cut->mesh.T.row(first) == c.domain.mesh.T.row(t));
    }
    CHECK(whole == cut->stats.tetsByTissueCount[0]);
  }
}

TEST_CASE("fields that are equal everywhere belong to the first muscle") {
  test::GeneratedAnatomy c = test::generatedAnatomy(0);
  c.fields.values = test::generatedFields(c.domain.mesh.V, FieldKind::AllEqual, 5, 1);
  RunContext run;
  const auto cut = envelope::computeEnvelope(c.domain.mesh, c.domain.neighbours, c.fields.values,
                                             {.strikeIslands = false}, run);
  REQUIRE(cut);
  CHECK(cut->mesh.T == c.domain.mesh.T);
  CHECK(std::ranges::all_of(cut->label, [](TissueId id) { return id == kFirstMuscle; }));
}

TEST_CASE("one and two threads give the same bytes") {
  for (const std::uint64_t seed : {1, 2, 3, 5, 8, 13, 21}) {
    const test::GeneratedAnatomy c = test::generatedAnatomy(seed);
    INFO(c.name);
    RunContext run;
    const auto cutWith = [&](int threads) {
      const ThreadLimit limit(threads);
      return envelope::buildAnatomy(c.domain, c.fields, noCurves(), plain(c.fields), run)
          .value()
          .anatomy;
    };
    const auto one = cutWith(1);
    const auto two = cutWith(2);
    CHECK(one.mesh.T == two.mesh.T);
    REQUIRE(one.mesh.V.size() == two.mesh.V.size());
    CHECK(std::memcmp(one.mesh.V.data(), two.mesh.V.data(),
                      sizeof(double) * static_cast<std::size_t>(one.mesh.V.size())) == 0);
    CHECK(one.label == two.label);
    CHECK(one.neighbours == two.neighbours);
  }
}

TEST_CASE("the order of muscles changes nothing where fields do not tie") {
  const test::GeneratedAnatomy c = test::generatedAnatomy(9);  // bumps
  const Eigen::Index n = c.fields.values.cols();
  tissue::FieldMatrix turned = c.fields.values;
  for (Eigen::Index i = 1; i < n; ++i) turned.col(i) = c.fields.values.col(n - i);
  RunContext run;
  const auto volumes = [&](const tissue::FieldMatrix& fields) {
    const auto cut = envelope::computeEnvelope(c.domain.mesh, c.domain.neighbours, fields,
                                               {.strikeIslands = false}, run);
    std::vector<double> volume(static_cast<std::size_t>(n) + 1, 0.0);
    for (Eigen::Index t = 0; t < cut->mesh.T.rows(); ++t) {
      volume[static_cast<std::size_t>(cut->label[static_cast<std::size_t>(t)].value)] +=
          mesh::signedVolume(cut->mesh, t);
    }
    return volume;
  };
  const auto a = volumes(c.fields.values);
  const auto b = volumes(turned);
  CHECK(a[1] == Approx(b[1]).epsilon(1e-9).margin(1e-12));
  for (std::size_t i = 2; i < a.size(); ++i) {
    CHECK(a[i] == Approx(b[a.size() + 1 - i]).epsilon(1e-9).margin(1e-12));
  }
}

TEST_CASE("a ramp against a constant is cut where they are equal") {
  // f = z against 0.37 in the unit cube: the muscle is the slab above
  const domain::Domain box = test::boxDomain({.cells = {3, 3, 4}, .jitter = 0.2, .seed = 3});
  tissue::FieldMatrix fields(box.mesh.V.rows(), 2);
  fields.col(0).setConstant(0.37);
  fields.col(1) = box.mesh.V.col(2);
  RunContext run;
  const auto cut =
      envelope::computeEnvelope(box.mesh, box.neighbours, fields, {.strikeIslands = false}, run);
  REQUIRE(cut);
  double above = 0.0;
  for (Eigen::Index t = 0; t < cut->mesh.T.rows(); ++t) {
    if (cut->label[static_cast<std::size_t>(t)] == kFirstMuscle)
      above += mesh::signedVolume(cut->mesh, t);
  }
  CHECK(above == Approx(0.63).epsilon(cut->stats.clampedVertices > 0 ? 1e-3 : 1e-12));
}

TEST_CASE("exact places are kept, and what has no volume is counted") {
  const domain::Domain box = test::boxDomain({.cells = {3, 3, 3}});
  const auto fields = test::generatedFields(box.mesh.V, FieldKind::TwoValues, 4, 5);
  RunContext run;
  const auto cut = envelope::computeEnvelope(box.mesh, box.neighbours, fields,
                                             {.exact = true, .strikeIslands = false}, run);
  REQUIRE(cut);
  std::int64_t zero = 0;
  for (Eigen::Index t = 0; t < cut->mesh.T.rows(); ++t)
    zero += mesh::orientation(cut->mesh, t) == 0;
  CHECK(zero > 0);
  CHECK(zero == cut->stats.zeroTets);
  CHECK(cut->stats.clampedVertices == 0);
  CHECK(cut->stats.repairedVertices == 0);
  CHECK(cut->stats.unmatchedFaces == 0);
  CHECK(cut->stats.unexplainedOffLabelTets == 0);
}

TEST_CASE("fields that are no numbers are named by tissue and vertex") {
  test::GeneratedAnatomy c = test::generatedAnatomy(9);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    tissue::FieldMatrix fields = c.fields.values;
    fields(5, 1) = bad;
    RunContext run;
    const auto cut = envelope::computeEnvelope(c.domain.mesh, c.domain.neighbours, fields, {}, run);
    REQUIRE_FALSE(cut);
    CHECK(cut.error().code == ErrorCode::NonFiniteField);
    CHECK(cut.error().message.find("tissue 2") != std::string::npos);
    CHECK(cut.error().message.find("vertex 5") != std::string::npos);
  }
}

TEST_CASE("a cancelled run says so") {
  const test::GeneratedAnatomy c = test::generatedAnatomy(9);
  RunContext run;
  run.cancel();
  const auto cut =
      envelope::computeEnvelope(c.domain.mesh, c.domain.neighbours, c.fields.values, {}, run);
  REQUIRE_FALSE(cut);
  CHECK(cut.error().code == ErrorCode::Cancelled);
}
