#include <ecorche/core/parallel.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/mesh/disjoint_sets.h>
#include <ecorche/mesh/orientation.h>

#include <catch2/catch.hpp>
#include <cstring>
#include <random>

#include "anatomy_faults.h"
#include "support/cases.h"
#include "support/generated_anatomy.h"
#include "support/generated_domain.h"

using namespace ecorche;
using envelope::TissueInTet;

namespace {

std::size_t at(std::int64_t i) { return static_cast<std::size_t>(i); }

std::vector<double> volumes(const envelope::Envelope& cut, Eigen::Index fieldCount) {
  std::vector<double> volume(at(fieldCount) + 1, 0.0);
  for (Eigen::Index t = 0; t < cut.mesh.T.rows(); ++t) {
    volume[at(cut.label[at(t)].value)] += mesh::signedVolume(cut.mesh, t);
  }
  return volume;
}

/// A few tets for each muscle in which it owns something, as if its curve ran there.
std::vector<TissueInTet> someSeeds(const envelope::Envelope& cut, int fieldCount,
                                   std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<std::vector<std::int32_t>> parents(at(fieldCount) + 1);
  for (std::size_t t = 0; t < cut.label.size(); ++t) {
    parents[at(cut.label[t].value)].push_back(cut.parentTet[t]);
  }
  std::vector<TissueInTet> seeds;
  for (std::int32_t id = kFirstMuscle.value; id <= fieldCount; ++id) {
    const auto& own = parents[at(id)];
    for (std::size_t n = 0; n < std::min<std::size_t>(own.size(), 2); ++n) {
      seeds.push_back({own[random() % own.size()], TissueId(id)});
    }
  }
  return seeds;
}

/// How many pieces of muscles, connected through faces, lie in no tet of their seeds.
std::int64_t unseededPieces(const envelope::Envelope& cut, const std::vector<TissueInTet>& seeds) {
  mesh::DisjointSets sets(cut.label.size());
  for (Eigen::Index t = 0; t < cut.mesh.T.rows(); ++t) {
    for (int k = 0; k < 4; ++k) {
      const std::int32_t u = cut.neighbours(t, k);
      if (u > t && cut.label[at(u)] == cut.label[at(t)])
        sets.unite(static_cast<std::int32_t>(t), u);
    }
  }
  std::vector<std::int32_t> piece;
  std::vector<std::uint8_t> seeded(at(sets.label(piece)), 0);
  std::vector<std::uint8_t> muscle(seeded.size(), 0);
  for (std::size_t t = 0; t < piece.size(); ++t) {
    muscle[at(piece[t])] = cut.label[t] != kFat;
    if (std::ranges::find(seeds, TissueInTet{cut.parentTet[t], cut.label[t]}) != seeds.end()) {
      seeded[at(piece[t])] = 1;
    }
  }
  std::int64_t count = 0;
  for (std::size_t p = 0; p < seeded.size(); ++p) count += muscle[p] && !seeded[p];
  return count;
}

/// Two bumps of one muscle far apart in a long box, and another muscle; fat between them.
tissue::FieldMatrix twoBumps(const mesh::Positions& V, bool second) {
  tissue::FieldMatrix fields(V.rows(), 3);
  const auto bump = [&](Eigen::Index v, double x) {
    return std::max(0.0, 1.0 - 4.0 * (V.row(v) - Eigen::RowVector3d(x, 0.47, 0.52)).norm());
  };
  for (Eigen::Index v = 0; v < V.rows(); ++v) {
    fields(v, 0) = 0.31;
    fields(v, 1) = bump(v, 0.6) + (second ? bump(v, 2.4) : 0.0);
    fields(v, 2) = 0.9 * bump(v, 2.2);
  }
  return fields;
}

}  // namespace

TEST_CASE("an island goes to what lies below it, as if it had never been there") {
  domain::Domain box = test::boxDomain({.cells = {24, 8, 8}, .jitter = 0.2, .seed = 4});
  box.mesh.V.col(0) *= 3.0;
  const auto fields = twoBumps(box.mesh.V, true);
  const mesh::Vector3 middle(0.6, 0.47, 0.52);
  std::int32_t seed = 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (std::int32_t t = 0; t < box.mesh.T.rows(); ++t) {
    mesh::Vector3 centre = mesh::Vector3::Zero();
    for (int c = 0; c < 4; ++c) centre += 0.25 * box.mesh.V.row(box.mesh.T(t, c)).transpose();
    if ((centre - middle).norm() >= nearest) continue;
    nearest = (centre - middle).norm();
    seed = t;
  }
  std::int32_t other = 0;
  fields.col(2).maxCoeff(&other);
  std::vector<TissueInTet> seeds{{seed, TissueId(2)}};
  for (std::int32_t t = 0; t < box.mesh.T.rows(); ++t) {
    if ((box.mesh.T.row(t).array() == other).any()) seeds.push_back({t, TissueId(3)});
  }

  RunContext run;
  const auto with =
      envelope::computeEnvelope(box.mesh, box.neighbours, fields, {.strikeIslands = false}, run);
  const auto struck =
      envelope::computeEnvelope(box.mesh, box.neighbours, fields, {.seeds = seeds}, run);
  const auto without = envelope::computeEnvelope(
      box.mesh, box.neighbours, twoBumps(box.mesh.V, false), {.strikeIslands = false}, run);
  REQUIRE(with);
  REQUIRE(struck);
  REQUIRE(without);
  CHECK(struck->stats.islands == 1);
  CHECK(struck->stats.lostTissues.empty());
  CHECK(struck->mesh.T == without->mesh.T);
  CHECK(struck->mesh.V == without->mesh.V);
  CHECK(struck->label == without->label);
  const double lost = volumes(*with, 3)[2] - volumes(*struck, 3)[2];
  CHECK(lost > 1e-3);
  CHECK(struck->stats.islandVolume[2] == Approx(lost).epsilon(1e-2));
  CHECK(struck->stats.unexplainedOffLabelTets == 0);
}

TEST_CASE("a muscle of which no part holds its curve is lost, and named") {
  const test::GeneratedAnatomy c = test::generatedAnatomy(9);
  RunContext run;
  const auto cut = envelope::computeEnvelope(c.domain.mesh, c.domain.neighbours, c.fields.values,
                                             {.fatIsCandidate = true}, run);
  if (!cut) FAIL(cut.error().message);
  CHECK(cut->stats.islands > 0);
  CHECK(std::ranges::all_of(cut->label, [](TissueId id) { return id == kFat; }));
  CHECK(cut->mesh.T == c.domain.mesh.T);
  CHECK(cut->stats.lostTissues.size() == at(c.fields.values.cols()) - 1);
}

TEST_CASE("islands are struck so that neighbours agree, until none is left") {
  std::int64_t islands = 0;
  const auto seeds = test::casesHere(210);
  for (const std::uint64_t seed : seeds) {
    const test::GeneratedAnatomy c = test::generatedAnatomy(seed);
    INFO(c.name);
    const auto fieldCount = static_cast<int>(c.fields.values.cols());
    RunContext run;
    envelope::EnvelopeOptions options{.fatIsCandidate = c.fields.fatIsCandidate,
                                      .strikeIslands = false};
    const auto plain = envelope::computeEnvelope(c.domain.mesh, c.domain.neighbours,
                                                 c.fields.values, options, run);
    REQUIRE(plain);
    options.strikeIslands = true;
    options.seeds = someSeeds(*plain, fieldCount, seed);
    const auto cutWith = [&](int threads) {
      const ThreadLimit limit(threads);
      return envelope::computeEnvelope(c.domain.mesh, c.domain.neighbours, c.fields.values, options,
                                       run);
    };
    const auto cut = cutWith(2);
    if (!cut) FAIL(cut.error().message);
    islands += cut->stats.islands;

    const auto adjacency = mesh::tetAdjacency(cut->mesh.T);
    CHECK(adjacency.nonManifoldFaces == 0);
    CHECK(adjacency.neighbours == cut->neighbours);
    CHECK(cut->stats.unmatchedFaces == 0);
    CHECK(cut->stats.nonPositiveTets == 0);
    CHECK(cut->stats.unexplainedOffLabelTets == 0);
    CHECK(std::abs(mesh::signedVolumes(cut->mesh).sum() - c.domain.volume) <=
          1e-12 * c.domain.volume);
    CHECK(test::brokenLinks(cut->mesh.T, cut->mesh.V.rows(), cut->label) == 0);
    // Tets that are cut anew may lose what joined two parts inside them
    if (cut->stats.rebuiltTets == 0) {
      CHECK(unseededPieces(*cut, options.seeds) == cut->stats.keptIslands);
    }
    if (seed % 7 == 0) {
      const auto one = cutWith(1);
      CHECK(one->mesh.T == cut->mesh.T);
      CHECK(one->mesh.V == cut->mesh.V);
      CHECK(one->label == cut->label);
    }
  }
  CHECK(islands > 1000 * std::ssize(seeds) / 210);
}
