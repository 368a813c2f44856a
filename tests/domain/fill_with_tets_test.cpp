#include <ecorche/domain/fill_with_tets.h>
#include <ecorche/domain/interior_points.h>
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "support/environment.h"
#include "support/paths.h"
#include "support/patience.h"
#include "support/shapes.h"

using namespace ecorche;
using namespace ecorche::domain;
using mesh::Vector3;

namespace {

constexpr double kEdge = 0.02;

/// A ball of 10 cm, or whatever else, with an even edge length wanted inside.
struct Case {
  explicit Case(const mesh::SurfaceMesh& mesh)
      : walls(tagged(mesh, {BoundaryTag::Kind::Skin, 0})),
        points(0, 3),
        sizing(mesh::boundingBox(mesh), {}, kEdge, 0.0) {}
  [[nodiscard]] FillTask task() const {
    return {walls, points, walls, planes, bones, sizing, 1.0, 0.002, 60.0};
  }
  TaggedSurface walls;
  mesh::Positions points;
  std::vector<CutPlane> planes;
  std::vector<std::string> bones;
  SizingField sizing;
};

mesh::SurfaceMesh ball(const Vector3& centre = Vector3::Zero()) {
  return test::sphere(centre, 0.1, 3);
}

/// Two balls through one another, as one surface.
mesh::SurfaceMesh crossing() {
  mesh::SurfaceMesh out = mesh::joined({ball(), ball({0.08, 0.011, 0.007})}, "skin");
  out.parts.clear();
  return out;
}

double volumeOf(const TetAnswer& answer) {
  return mesh::signedVolumes({answer.V, answer.T}).cwiseAbs().sum();
}

/// The true worker, but for what the script says first.
std::string before(const std::string& script) {
  return fmt::format("{}\nexec '{}/ecorche-worker' \"$@\"", script, ECORCHE_BIN_DIR);
}

constexpr const char* kNoTetgen =
    "if [ $1 = tetrahedralize ]; then echo 'error MeshingFailed TetGen gave up: no luck' >&2; exit "
    "1; fi";

/// The ball, filled with a worker that the script meddles with.
Result<Fill> fillBall(const std::string& script, RunContext& run, double timeout = 60.0) {
  const test::TempFolder temp;
  const test::Environment worker("ECORCHE_WORKER",
                                 test::pretendWorker(temp.path(), before(script)).string());
  const Case ball(::ball());
  FillTask task = ball.task();
  task.workerTimeout = timeout;
  return fillWithTets(task, run);
}

bool empty(const std::filesystem::path& folder) { return std::filesystem::is_empty(folder); }

/// The working folder for one scope.
struct WorkingFolder {
  explicit WorkingFolder(const std::filesystem::path& folder) {
    std::filesystem::current_path(folder);
  }
  ~WorkingFolder() { std::filesystem::current_path(before); }
  std::filesystem::path before = std::filesystem::current_path();
};

}  // namespace

TEST_CASE("what TetGen takes is filled by TetGen, walls as they are") {
  const Case ball(::ball());
  RunContext run;
  const auto filled = fillWithTets(ball.task(), run);
  REQUIRE(filled);
  CHECK(filled->mesher == "TetGen");
  CHECK(filled->ofWalls);
  CHECK_FALSE(filled->fallback);
  CHECK(filled->findings.empty());
  CHECK(volumeOf(filled->tets) ==
        Approx(mesh::signedVolume(ball.walls.V, ball.walls.F)).epsilon(1e-9));
}

TEST_CASE("where TetGen refuses, Mesh_3 fills, and it is said") {
  RunContext run;
  const auto filled = fillBall(kNoTetgen, run);
  REQUIRE(filled);
  CHECK(filled->mesher == "CGAL Mesh_3");
  CHECK(filled->fallback);
  CHECK_FALSE(filled->ofWalls);
  CHECK(filled->fallbackReason == "TetGen gave up: no luck");
  REQUIRE(filled->findings.size() == 1);
  CHECK(filled->findings.front().kind == "fallback");
  const mesh::SurfaceMesh surface = ball();
  const double volume = volumeOf(filled->tets);
  CHECK(volume == Approx(mesh::signedVolume(surface.V, surface.F)).epsilon(0.02));
  // Sizes as wanted: about as many tets as a lattice of that edge has
  CHECK(double(filled->tets.T.rows()) == Approx(volume / latticeTetVolume(kEdge)).epsilon(0.4));
}

TEST_CASE("a TetGen that crashes or hangs is as one that refuses") {
  const bool hangs = GENERATE(false, true);
  RunContext run;
  const auto filled = fillBall(fmt::format("if [ $1 = tetrahedralize ]; then {}; fi",
                                           hangs ? "exec sleep 60" : "kill -SEGV $$"),
                               run, hangs ? 5.0 : 60.0);
  REQUIRE(filled);
  CHECK(filled->mesher == "CGAL Mesh_3");
}

TEST_CASE("what neither mesher takes: both reasons, the place, the way out, and no litter") {
  const test::TempFolder temp;
  const test::TempFolder here;
  const auto script =
      "if [ $1 = fill ]; then echo 'error MeshingFailed CGAL Mesh_3 gave up at x.h:1' >&2; exit 1; "
      "fi\n";
  const test::Environment worker(
      "ECORCHE_WORKER",
      test::pretendWorker(temp.path(), before(script + std::string(kNoTetgen))).string());
  const WorkingFolder working(here.path());
  const Case crossed(crossing());
  RunContext run;
  const auto filled = fillWithTets(crossed.task(), run);
  REQUIRE_FALSE(filled);
  CHECK(filled.error().code == ErrorCode::MeshingFailed);
  CHECK(filled.error().message.find("TetGen gave up: no luck") != std::string::npos);
  CHECK(filled.error().message.find("Mesh_3 gave up at x.h:1") != std::string::npos);
  // Both are skin: no other number of tets would help
  CHECK(filled.error().message.find("\"repair\": \"wrap\"") != std::string::npos);
  CHECK(filled.error().place.object == "skin");
  REQUIRE(filled.error().place.point);
  // On the circle in which the balls cross: equally far from both centres
  const Vector3 at = *filled.error().place.point;
  CHECK(at.norm() == Approx((at - Vector3(0.08, 0.011, 0.007)).norm()).margin(0.03));
  CHECK(empty(here.path()));
}

TEST_CASE(
    "surfaces that cross: Mesh_3 answers or refuses in a process of its own, without litter") {
  const test::TempFolder here;
  const WorkingFolder working(here.path());
  const Case crossed(crossing());
  RunContext run;
  const auto filled = fillWithTets(crossed.task(), run);
  if (filled) {
    CHECK(filled->fallback);
  } else {
    CHECK(filled.error().code == ErrorCode::MeshingFailed);
    CHECK(filled.error().message.find('\n') == std::string::npos);
  }
  CHECK(empty(here.path()));
}

TEST_CASE("a cancel is answered at once while Mesh_3 works") {
  RunContext run;
  std::chrono::steady_clock::time_point cancelled;
  std::jthread canceller([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    cancelled = std::chrono::steady_clock::now();
    run.cancel();
  });
  const auto filled =
      fillBall(std::string(kNoTetgen) + "\nif [ $1 = fill ]; then exec sleep 60; fi", run);
  canceller.join();
  REQUIRE_FALSE(filled);
  CHECK(filled.error().code == ErrorCode::Cancelled);
  CHECK(std::chrono::steady_clock::now() - cancelled < std::chrono::seconds(5 * test::kPatience));
}

TEST_CASE("files between us and the worker: read back as they were, refused where damaged") {
  Case ball(::ball());
  ball.planes = {{"half", {0.1, 0.2, 0.3}, {0, 1, 0}}};
  const FillRequest request{ball.walls, ball.planes, ball.sizing, 0.7, 0.002};
  const std::string bytes = encodeFillRequest(request);
  const auto back = decodeFillRequest(bytes);
  REQUIRE(back);
  CHECK(encodeFillRequest(*back) == bytes);
  CHECK(back->sizing.at({0.01, 0.02, 0.03}) == ball.sizing.at({0.01, 0.02, 0.03}));
  for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 97)
    CHECK_FALSE(decodeFillRequest(bytes.substr(0, length)));
}
