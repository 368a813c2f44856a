#include <ecorche/core/run_context.h>

#include <catch2/catch.hpp>
#include <thread>

using namespace ecorche;

TEST_CASE("stages within a stage are part of it, in the order in which they began") {
  RunContext run;
  {
    const Stage outer(run, "outer");
    { const Stage inner(run, "inner"); }
    std::thread([&] { const Stage elsewhere(run, "elsewhere"); }).join();
    { const Stage inner(run, "inner"); }
  }
  { const Stage next(run, "next"); }
  const auto times = run.stageTimes();
  REQUIRE(times.size() == 4);
  CHECK(times[0].stage == "outer");
  CHECK(times[1].stage == "inner");
  CHECK(times[2].stage == "elsewhere");
  CHECK(times[3].stage == "next");
  CHECK(times[0].level == 0);
  CHECK(times[1].level == 1);
  CHECK(times[2].level == 1);
  CHECK(times[3].level == 0);
  CHECK(times[1].seconds <= times[0].seconds);
}

TEST_CASE("stages side by side are parts of what both belong to, not of each other") {
  RunContext run;
  {
    const Stage outer(run, "output");
    const Stage inner(run, "write");
    std::thread([&] {
      const Stage elsewhere(run, "preview");
      const Stage part(run, "picture");
    }).join();
    const Stage part(run, "writing");
  }
  std::vector<std::pair<std::string, int>> seen;
  for (const auto& time : run.stageTimes()) seen.emplace_back(time.stage, time.level);
  CHECK(seen == std::vector<std::pair<std::string, int>>{
                    {"output", 0}, {"write", 1}, {"writing", 2}, {"preview", 1}, {"picture", 2}});
}

TEST_CASE("the same stage within two others is timed within each, beside its own") {
  RunContext run;
  {
    const Stage draft(run, "draft");
    const Stage carve(run, "carve");
  }
  { const Stage carve(run, "carve"); }
  {
    const Stage draft(run, "draft");
    const Stage cut(run, "cut");
  }
  const auto times = run.stageTimes();
  REQUIRE(times.size() == 4);
  const std::vector<std::string> order{"draft", "carve", "cut", "carve"};
  const std::vector<int> levels{0, 1, 1, 0};
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(times[i].stage == order[i]);
    CHECK(times[i].level == levels[i]);
  }
}

TEST_CASE("a stage that opens itself again counts once") {
  RunContext run;
  double outer = 0.0;
  {
    const Stage stage(run, "resample");
    { const Stage again(run, "resample"); }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    outer = stage.seconds();
  }
  REQUIRE(run.stageTimes().size() == 1);
  CHECK(run.stageTimes()[0].seconds >= outer);
  CHECK(run.stageTimes()[0].seconds < 2.0 * outer);
}
