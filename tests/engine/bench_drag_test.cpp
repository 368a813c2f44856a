#include <ecorche/engine/bench_drag.h>
#include <ecorche/model/project_file.h>

#include <catch2/catch.hpp>

using namespace ecorche;
using engine::DragScript;

namespace {

model::Project arm() {
  return model::loadProject(std::filesystem::path(ECORCHE_SOURCE_DIR) / "examples/arm/arm.ecorche")
      .value();
}

DragScript drag() {
  return {"down", "brachialis", 0, 1, 8, {{0, 0, 0}, {0.01, 0, 0}, {0.01, 0.01, 0}}};
}

}  // namespace

TEST_CASE("a recorded drag goes along its path at an even pace") {
  const DragScript script{"d", "m", 0, 0, 10, {{0, 0, 0}, {0.5, 0, 0}, {1, 0, 0}}};
  for (int frame = 0; frame <= 10; ++frame)
    CHECK((script.offset(frame) - mesh::Vector3(0.1 * frame, 0, 0)).norm() < 1e-9);
  CHECK(drag().offset(8).isApprox(mesh::Vector3(0.01, 0.01, 0), 1e-9));
}

TEST_CASE("a replayed drag is compared with solves from scratch") {
  RunContext run;
  const auto bench = engine::benchDrag(arm(), 40'000, {drag()}, 4, true, run);
  REQUIRE(bench);
  CHECK(bench->tets > 20'000);
  CHECK(bench->simplicial.value() > 0.0);
  REQUIRE(bench->runs.size() == 1);
  const engine::DragRun& done = bench->runs[0];
  CHECK(done.frame.seconds.size() == 8);
  CHECK(done.fieldError.size() + std::size_t(done.unchecked) == 2);
  for (const double error : done.fieldError) {
    CHECK(error > 0.0);  // a preview, not the answer
    CHECK(error < 0.03);
  }
  for (const double share : done.ownerShare) CHECK(share < 0.02);
}

TEST_CASE("a drag of what is not there is refused by name") {
  RunContext run;
  DragScript script = drag();
  script.point = 99;
  const auto none = engine::benchDrag(arm(), 20'000, {script}, 4, false, run);
  REQUIRE_FALSE(none.has_value());
  CHECK(none.error().code == ErrorCode::UnknownName);
  CHECK(none.error().place.object == "down");
}

TEST_CASE("an anisotropic muscle's drag is replayed, too") {
  RunContext run;
  auto project = arm();
  project.tissues[*model::findTissue(project, "brachialis")].anisotropy.lambda2 = 3.0;
  const auto bench = engine::benchDrag(project, 20'000, {drag()}, 4, false, run);
  REQUIRE(bench);
  REQUIRE_FALSE(bench->runs[0].fieldError.empty());
  for (const double error : bench->runs[0].fieldError) {
    CHECK(error > 0.0);
    CHECK(error < 0.1);  // its medium stays as it was settled
  }
}
