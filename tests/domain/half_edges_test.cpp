#include <ecorche/domain/half_edges.h>
#include <ecorche/mesh/surface_topology.h>
#include <support/shapes.h>

#include <catch2/catch.hpp>
#include <random>

using namespace ecorche;
using namespace ecorche::domain;

namespace {

/// Every pointer leads where its meaning says, and every live vertex has one closed ring.
std::string fault(const HalfEdges& he) {
  std::vector<int> degree(static_cast<std::size_t>(he.vertexCount()), 0);
  for (std::int32_t h = 0; h < he.halfEdgeCount(); ++h) {
    if (he.edgeAlive(h) != he.edgeAlive(HalfEdges::opposite(h))) return "an edge half alive";
    if (!he.edgeAlive(h)) continue;
    if (!he.edgeAlive(he.next(h))) return "a side of a live face is dead";
    if (he.next(he.next(he.next(h))) != h) return "a face is no triangle";
    if (he.face(he.next(h)) != he.face(h)) return "a face of two numbers";
    if (he.from(he.next(h)) != he.to(h)) return "sides of a face do not join";
    if (he.from(h) == he.to(h)) return "an edge from a vertex to itself";
    if (!he.vertexAlive(he.from(h))) return "a live edge at a dead vertex";
    ++degree[static_cast<std::size_t>(he.from(h))];
  }
  for (std::int32_t v = 0; v < he.vertexCount(); ++v) {
    if (!he.vertexAlive(v)) continue;
    if (he.from(he.someOutgoing(v)) != v) return "a vertex holds an edge of another";
    if (he.valence(v) != degree[static_cast<std::size_t>(v)]) return "a ring leaves edges out";
  }
  return {};
}

}  // namespace

TEST_CASE("half-edges stay a closed manifold under any splits, collapses and flips") {
  for (std::uint32_t seed = 1; seed <= 60; ++seed) {
    INFO("seed " << seed);
    std::mt19937 random(seed);
    const auto ball = test::sphere({0, 0, 0}, 1.0, 1 + static_cast<int>(seed % 2));
    auto he = HalfEdges::build(tagged(ball, {BoundaryTag::Kind::Skin, 0}));
    REQUIRE(he);
    // Runs of mostly one kind reach small rings and big ones
    int kind = 0;
    for (int step = 0; step < 1500; ++step) {
      if (step % 50 == 0) kind = static_cast<int>(random() % 3);
      const auto h =
          static_cast<std::int32_t>(random() % static_cast<unsigned>(he->halfEdgeCount()));
      if (!he->edgeAlive(h)) continue;
      const int what = random() % 4 == 0 ? static_cast<int>(random() % 3) : kind;
      if (what == 0 && he->vertexCount() < 400) {
        he->split(h);
      } else if (what == 1 && he->canCollapse(h)) {
        he->collapse(h);
      } else if (what == 2 && he->canFlip(h)) {
        he->flip(h);
      } else {
        continue;
      }
      INFO("step " << step << ", kind " << what);
      REQUIRE(fault(*he) == "");
    }
  }
}
