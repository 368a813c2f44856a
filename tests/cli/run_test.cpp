#include <ecorche/core/files.h>
#include <ecorche/model/project_file.h>

#include <algorithm>
#include <catch2/catch.hpp>

#include "model/sample_project.h"
#include "support/program.h"

using namespace ecorche;
using test::runEcorche;

TEST_CASE("run applies a script and saves the project") {
  test::TempFolder temp;
  REQUIRE(writeFileWhole(temp.path() / "arm.ecorche", test::kFullProject));
  REQUIRE(
      writeFileWhole(temp.path() / "s.txt",
                     "# thicker\npoint.value biceps 1 2 1.5\nmuscle.add brachialis\n"
                     "curve.add brachialis 0,0,0 0,0,0.1 start=bone:humerus end=bone:radius\n"));
  const auto run = runEcorche("run arm.ecorche s.txt", temp.path());
  CHECK(run.exitCode == 0);
  CHECK(run.out == "arm.ecorche: 3 commands applied\n");
  const auto project = model::loadProject(temp.path() / "arm.ecorche").value();
  CHECK(project.tissues[1].curves[0].points[1].tissue == 1.5);
  CHECK(project.tissues.back().name == "brachialis");
}

TEST_CASE("run reads standard input and writes elsewhere") {
  test::TempFolder temp;
  std::filesystem::create_directory(temp.path() / "copies");
  REQUIRE(writeFileWhole(temp.path() / "arm.ecorche", test::kFullProject));
  REQUIRE(writeFileWhole(temp.path() / "s.txt", "fat.set 0.5\n"));
  CHECK(
      runEcorche("--quiet run arm.ecorche - -o copies/fat.ecorche < s.txt", temp.path()).exitCode ==
      0);
  CHECK(readFile(temp.path() / "arm.ecorche").value() == test::kFullProject);
  const auto copy = model::loadProject(temp.path() / "copies" / "fat.ecorche").value();
  CHECK(copy.settings.fat == 0.5);
  CHECK(copy.skin.file == "../skin.obj");
}

TEST_CASE("one wrong line of a script and nothing is written") {
  test::TempFolder temp;
  REQUIRE(writeFileWhole(temp.path() / "arm.ecorche", test::kFullProject));
  const std::vector<std::pair<const char*, const char*>> cases = {
      {"fat.set 0.5\nfat.sat 1\n", "ecorche: s.txt:2:1: there is no command \"fat.sat\""},
      {"fat.set 0.5\n\npoint.remove biceps 7 1\n",
       "ecorche: s.txt:3: there is no curve 7 in \"biceps\"; it has 2"},
      {"muscle.add triceps\n",
       "ecorche: muscle \"triceps\" has no curve; draw one or delete the muscle"},
  };
  for (const auto& [script, message] : cases) {
    REQUIRE(writeFileWhole(temp.path() / "s.txt", script));
    const auto run = runEcorche("run arm.ecorche s.txt", temp.path());
    CHECK(run.exitCode == 1);
    CHECK(run.out.empty());
    CHECK(run.err.starts_with(message));
    CHECK(readFile(temp.path() / "arm.ecorche").value() == test::kFullProject);
  }
  CHECK(runEcorche("run arm.ecorche no.txt", temp.path()).exitCode == 1);
}
