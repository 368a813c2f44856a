#include <ecorche/engine/bench_settle.h>
#include <ecorche/model/project_file.h>

#include <catch2/catch.hpp>

using namespace ecorche;
using engine::DragScript;

TEST_CASE("drags that are let go of settle at solves from scratch") {
  RunContext run;
  auto project =
      model::loadProject(std::filesystem::path(ECORCHE_SOURCE_DIR) / "examples/arm/arm.ecorche")
          .value();
  // One of them is not, and then everything is solved for as a whole
  for (model::Tissue& tissue : project.tissues) tissue.anisotropy = {};
  const std::vector<DragScript> drags{
      {"down", "brachialis", 0, 1, 8, {{0, 0, 0}, {0.01, 0, 0}, {0.01, 0.01, 0}}},
      {"aside", "triceps_brachii", 0, 1, 8, {{0, 0, 0}, {0, 0.01, 0}}}};
  const auto bench = engine::benchSettle(project, 40'000, drags, 4, run);
  REQUIRE(bench);
  CHECK(bench->tets > 20'000);
  REQUIRE(bench->runs.size() == 2);
  for (const engine::SettleRun& done : bench->runs) {
    INFO(done.name);
    CHECK(done.settle.seconds.size() + std::size_t(done.unchecked) == 4);
    CHECK(done.abandoned.seconds.size() <= done.settle.seconds.size());
    CHECK((done.meanwhile.seconds.empty() || !done.abandoned.seconds.empty()));
    CHECK(done.fieldError.size() == done.settle.seconds.size());
    for (const double error : done.fieldError) {
      CHECK(error > 0.0);  // another way to the same
      CHECK(error < 1e-8);
    }
    for (const double share : done.factored) CHECK(share < 1.0);
    CHECK(done.ownersOff <= 1);
  }
  const auto none = engine::benchSettle(project, 20'000, {{"x", "nobody", 0, 0, 8, {}}}, 4, run);
  REQUIRE_FALSE(none);
  CHECK(none.error().code == ErrorCode::UnknownName);
}
