#include <ecorche/core/parallel.h>
#include <ecorche/envelope/envelope.h>
#include <ecorche/mesh/surface_mesh.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "support/generated_domain.h"

using namespace ecorche;

namespace {

struct Case {
  mesh::TetMesh mesh;
  mesh::TetNeighbours neighbours;
  tissue::FieldMatrix fields;
};

// Noise at the vertices, rounded to multiples of 1/steps where steps > 0: many exact ties
Case noise(std::uint64_t seed, int fieldCount, int steps) {
  Case out;
  test::Grid grid;
  grid.cells = Eigen::Array3i(3, 4, 3);
  grid.jitter = 0.2;
  grid.seed = seed;
  out.mesh = test::kuhnGrid(grid);
  out.neighbours = mesh::tetAdjacency(out.mesh.T).neighbours;
  out.fields.resize(out.mesh.V.rows(), fieldCount);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for (Eigen::Index i = 0; i < out.fields.size(); ++i) {
    const double x = uniform(random);
    out.fields.data()[i] = steps > 0 ? std::round(x * steps) / steps : x;
  }
  return out;
}

}  // namespace

TEST_CASE("the envelope is conforming, fills the domain and keeps its boundary") {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    INFO("seed " << seed);
    constexpr int kSteps[4] = {0, 4, 16, 1};
    const Case c = noise(seed, 2 + static_cast<int>(seed % 7), kSteps[seed % 4]);
    RunContext run;
    envelope::EnvelopeOptions options;
    options.strikeIslands = false;
    const auto cut = envelope::computeEnvelope(c.mesh, c.neighbours, c.fields, options, run);
    REQUIRE(cut);
    const auto adjacency = mesh::tetAdjacency(cut->mesh.T);
    CHECK(adjacency.nonManifoldFaces == 0);
    const double volume = mesh::signedVolumes(c.mesh).sum();
    CHECK(mesh::signedVolumes(cut->mesh).sum() == Approx(volume).epsilon(1e-9));
    // Interior faces without a partner would count as boundary and add to its area
    const auto before = mesh::tetBoundary(c.mesh.T, c.neighbours);
    const auto after = mesh::tetBoundary(cut->mesh.T, adjacency.neighbours);
    CHECK(mesh::signedVolume(cut->mesh.V, after.F) == Approx(volume).epsilon(1e-9));
    if (cut->stats.nonPositiveTets == 0) {
      CHECK(mesh::surfaceArea(cut->mesh.V, after.F) ==
            Approx(mesh::surfaceArea(c.mesh.V, before.F)).epsilon(1e-9));
    }
    CHECK(cut->stats.unexplainedOffLabelTets == 0);
  }
}

TEST_CASE("two or three smooth tissues leave every tet with volume") {
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    INFO("seed " << seed);
    Case c = noise(seed, 3, 0);
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    for (Eigen::Index i = 0; i < c.fields.cols(); ++i) {
      const Eigen::RowVector3d centre(uniform(random), uniform(random), uniform(random));
      for (Eigen::Index v = 0; v < c.fields.rows(); ++v) {
        c.fields(v, i) = std::exp(-4.0 * (c.mesh.V.row(v) - centre).squaredNorm());
      }
    }
    RunContext run;
    const auto cut =
        envelope::computeEnvelope(c.mesh, c.neighbours, c.fields, {.strikeIslands = false}, run);
    REQUIRE(cut);
    CHECK(cut->stats.nonPositiveTets == 0);
  }
}

TEST_CASE("one and two threads give the same tets") {
  const Case c = noise(7, 6, 16);
  RunContext run;
  const auto cutWith = [&](int threads) {
    const ThreadLimit limit(threads);
    return envelope::computeEnvelope(c.mesh, c.neighbours, c.fields, {.strikeIslands = false}, run)
        .value();
  };
  const auto one = cutWith(1);
  const auto two = cutWith(2);
  CHECK(one.mesh.T == two.mesh.T);
  CHECK(one.mesh.V == two.mesh.V);
}

TEST_CASE("fields that are no numbers are named by tissue and vertex") {
  Case c = noise(1, 3, 0);
  c.fields(5, 2) = std::nan("");
  RunContext run;
  const auto cut = envelope::computeEnvelope(c.mesh, c.neighbours, c.fields, {}, run);
  REQUIRE_FALSE(cut);
  CHECK(cut.error().code == ErrorCode::NonFiniteField);
  CHECK(cut.error().message.find("tissue 3") != std::string::npos);
}
