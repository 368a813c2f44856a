#include <ecorche/core/files.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "model/sample_project.h"
#include "support/program.h"

using namespace ecorche;
using test::runEcorche;

TEST_CASE("wrong usage is answered with 2, help with 0") {
  test::TempFolder temp;
  CHECK(runEcorche("", temp.path()).exitCode == 2);
  CHECK(runEcorche("info", temp.path()).exitCode == 2);
  CHECK(runEcorche("info a.ecorche --frobnicate", temp.path()).exitCode == 2);
  CHECK(runEcorche("--threads 0 info a.ecorche", temp.path()).exitCode == 2);
  const auto unknown = runEcorche("dissect a.ecorche", temp.path());
  CHECK(unknown.exitCode == 2);
  CHECK(unknown.err.find("no command \"dissect\"") != std::string::npos);

  CHECK(runEcorche("--version", temp.path()).exitCode == 0);
  const auto help = runEcorche("info --help", temp.path());
  CHECK(help.exitCode == 0);
  CHECK(help.out.find("Examples:") != std::string::npos);
}

TEST_CASE("a faulty project is answered with 1 and one line: what, where, way out") {
  test::TempFolder temp;
  REQUIRE(
      writeFileWhole(temp.path() / "bad.ecorche", test::fullProjectWith("\"layer\"", "\"lair\"")));
  const auto plain = runEcorche("info bad.ecorche", temp.path());
  CHECK(plain.exitCode == 1);
  CHECK(plain.out.empty());
  CHECK(plain.err.starts_with("ecorche: bad.ecorche:22:7: muscle \"biceps\" has no \"lair\""));
  CHECK(std::ranges::count(plain.err, '\n') == 1);

  const auto json = runEcorche("info bad.ecorche --json", temp.path());
  CHECK(json.exitCode == 1);
  const auto error = nlohmann::json::parse(json.out).at("error");
  CHECK(error.at("code") == "UnknownKey");
  CHECK(error.at("line") == 22);
  CHECK(error.at("column") == 7);

  CHECK(runEcorche("info no.ecorche", temp.path()).exitCode == 1);
}

TEST_CASE("info tells what a project holds, as a table and as JSON") {
  test::TempFolder temp;
  REQUIRE(writeFileWhole(temp.path() / "arm.ecorche", test::kFullProject));
  const auto table = runEcorche("info arm.ecorche", temp.path());
  CHECK(table.exitCode == 0);
  CHECK(table.err.empty());
  CHECK(table.out.find(" 2  biceps ") != std::string::npos);
  CHECK(table.out.find("bones.obj") != std::string::npos);  // it is not there

  const auto run = runEcorche("--json info arm.ecorche", temp.path());
  CHECK(run.exitCode == 0);
  const auto json = nlohmann::json::parse(run.out);
  CHECK(json.at("name") == "forearm");
  CHECK(json.at("bones") == nlohmann::json{"humerus", "radius"});
  CHECK(json.at("tissues").at(1).at("id") == 2);
  CHECK(json.at("tissues").at(2).at("curves").at(0).at("length_m").get<double>() == Approx(0.09));
  CHECK(json.at("missing_files").size() == 6);
}

TEST_CASE("a preview is refused where there are no fields to draw, with the way out") {
  test::TempFolder temp;
  std::filesystem::create_directory(temp.path() / "out");
  const auto folder = runEcorche("render out -o a.png --preview", temp.path());
  CHECK(folder.exitCode == 1);
  CHECK(folder.err.find("render the project instead") != std::string::npos);
}
