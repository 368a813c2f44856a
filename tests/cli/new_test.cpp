#include <ecorche/core/files.h>
#include <ecorche/model/project_file.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "support/program.h"

using namespace ecorche;
using test::runEcorche;
namespace fs = std::filesystem;

namespace {

// A box, lopsided in x and z but not in y, and smaller boxes in it
std::string box(double x0, double x1, double y, double z, const char* group) {
  return fmt::format(
      "g {7}\nv {0} -{2} -{3}\nv {1} -{4} -{5}\nv {1} {4} -{5}\nv {0} {2} -{3}\n"
      "v {0} -{2} {6}\nv {1} -{4} {3}\nv {1} {4} {3}\nv {0} {2} {6}\n"
      "f -8 -5 -6 -7\nf -4 -3 -2 -1\nf -8 -7 -3 -4\nf -7 -6 -2 -3\nf -6 -5 -1 -2\nf -5 -8 -4 -1\n",
      x0, x1, y, z, 0.5 * y, 0.7 * z, 2 * z, group);
}

/// A folder with a skin, a folder of bones and a table; lengths in centimetres.
struct Model {
  test::TempFolder temp;
  Model() {
    fs::create_directories(temp.path() / "meshes" / "bones");
    write("meshes/skin.obj", box(-10, 10, 4, 3, "skin"));
    write("meshes/bones/BONEhumerus.obj", box(-6, -5, 0.5, 0.5, "h"));
    write("meshes/bones/forearm.obj", box(4, 5, 0.5, 0.5, "radius") + box(6, 7, 0.5, 0.5, "ulna"));
    write("meshes/bones/readme.txt", "no mesh");
    write("table.csv",
          "muscle,role,bone,x,y,z\n"
          "biceps,origin,humerus,-5,0.3,0\nbiceps,insertion,radius,4,0.3,0\n"
          "triceps_R,,humerus,-5,-2,0\ntriceps_R,,ulna,6,-2,0\n");
  }
  void write(const char* file, const std::string& text) const {
    REQUIRE(writeFileWhole(temp.path() / file, text));
  }
  [[nodiscard]] test::Outcome run(const std::string& arguments) const {
    return runEcorche(arguments, temp.path());
  }
};

const std::string kNew = "new --skin meshes/skin.obj --bones meshes/bones --unit cm ";

}  // namespace

TEST_CASE("new makes a project from a skin, a folder of bones and a table") {
  Model model;
  const auto run = model.run(kNew + "--attachments table.csv -o work.ecorche --json");
  INFO(run.err);
  REQUIRE(run.exitCode == 0);
  const auto json = nlohmann::json::parse(run.out);
  CHECK(json.at("bones") == 3);
  CHECK(json.at("muscles") == 1);
  CHECK(json.at("muscles_in_table") == 2);

  const auto project = model::loadProject(model.temp.path() / "work.ecorche").value();
  CHECK(project.name == "work");
  CHECK(project.unit == model::Unit::Centimetre);
  CHECK(project.skin.file == "meshes/skin.obj");
  REQUIRE(project.bones.size() == 3);
  CHECK(project.bones[0].name == "humerus");
  CHECK(project.bones[0].mesh == model::MeshRef{"meshes/bones/BONEhumerus.obj", "", {}});
  CHECK(project.bones[1].name == "radius");
  CHECK(project.bones[2].mesh == model::MeshRef{"meshes/bones/forearm.obj", "ulna", {}});
  REQUIRE(project.cutPlanes.size() == 1);
  CHECK(project.cutPlanes[0].normal == model::Vector3::UnitY());
  REQUIRE(project.tissues.size() == 1);
  CHECK(project.tissues[0].curves[0].start.name == "humerus");
  CHECK(project.tissues[0].curves[0].end.name == "radius");
  CHECK((project.tissues[0].curves[0].points.back().at - model::Vector3(0.04, 0.003, 0)).norm() <
        1e-3);
  CHECK(model.run("info work.ecorche").out.find("not found") == std::string::npos);
}

TEST_CASE("new makes the muscles that are asked for, on both sides of a whole body") {
  Model model;
  const auto whole = model.run(kNew + "--attachments table.csv --whole -o whole.ecorche --json");
  INFO(whole.err);
  REQUIRE(whole.exitCode == 0);
  CHECK(nlohmann::json::parse(whole.out).at("symmetry").at("cuts") == false);
  const auto project = model::loadProject(model.temp.path() / "whole.ecorche").value();
  CHECK(project.cutPlanes.empty());
  CHECK(project.tissues.size() == 2);

  model.write("list.txt", "# upper arm\ntriceps\n");
  REQUIRE(model.run(kNew + "--attachments table.csv --whole --muscles list.txt -o p.ecorche")
              .exitCode == 0);
  const auto chosen = model::loadProject(model.temp.path() / "p.ecorche").value();
  REQUIRE(chosen.tissues.size() == 1);
  CHECK(chosen.tissues[0].name == "triceps_R");

  const auto unknown = model.run(kNew + "--attachments table.csv --muscles bicep -o q.ecorche");
  CHECK(unknown.exitCode == 1);
  CHECK(unknown.err.find("no muscle \"bicep\"; it has biceps") != std::string::npos);
  CHECK_FALSE(fs::exists(model.temp.path() / "q.ecorche"));
  // A choice of nothing
  CHECK(model.run(kNew + "--muscles biceps -o q.ecorche").exitCode == 2);
}

TEST_CASE("new does not replace a project unless told to") {
  Model model;
  REQUIRE(model.run(kNew + "-o work.ecorche").exitCode == 0);
  const std::string before = readFile(model.temp.path() / "work.ecorche").value();
  const auto again = model.run(kNew + "--symmetry none -o work.ecorche");
  CHECK(again.exitCode == 1);
  CHECK(again.err.find("--force") != std::string::npos);
  CHECK(readFile(model.temp.path() / "work.ecorche").value() == before);
  CHECK(model.run(kNew + "--symmetry none --force -o work.ecorche").exitCode == 0);
  CHECK(model::loadProject(model.temp.path() / "work.ecorche").value().cutPlanes.empty());
}

TEST_CASE("new takes a given plane, a part of a file, and writes relative to the project") {
  Model model;
  fs::create_directory(model.temp.path() / "projects");
  const auto run = model.run(
      "new --skin meshes/bones/forearm.obj --skin-part ulna --bones meshes/bones/BONEhumerus.obj "
      "--unit cm --symmetry -x=1.5 -o projects/p.ecorche --quiet");
  INFO(run.err);
  CHECK(run.exitCode == 0);
  CHECK(run.out.empty());
  const auto project = model::loadProject(model.temp.path() / "projects" / "p.ecorche").value();
  CHECK(project.skin == model::MeshRef{"../meshes/bones/forearm.obj", "ulna", {}});
  CHECK(project.cutPlanes.at(0).normal == -model::Vector3::UnitX());
  CHECK(project.cutPlanes.at(0).point == model::Vector3(0.015, 0, 0));
}

TEST_CASE("new says what is wrong and writes nothing") {
  Model model;
  model.write("bad.csv", "muscle,bone,x,y,z\na,b,1,2,zzz\n");
  model.write("empty.obj", "");
  fs::create_directory(model.temp.path() / "nothing");
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"new --skin no.obj --bones meshes/bones -o p.ecorche", "no.obj"},
      {"new --skin empty.obj --bones meshes/bones -o p.ecorche", "empty.obj"},
      {"new --skin meshes/skin.obj --bones nothing -o p.ecorche",
       "nothing: there is no mesh in this folder"},
      {"new --skin meshes/skin.obj --bones meshes/bones/readme.txt -o p.ecorche", "readme.txt"},
      {"new --skin meshes/skin.obj --skin-part head --bones meshes/bones -o p.ecorche",
       "there is no part \"head\""},
      {kNew + "--attachments bad.csv -o p.ecorche", "bad.csv:2:9: \"zzz\" is not a number"},
      {kNew + "-o no/such/folder/p.ecorche", "p.ecorche"},
  };
  for (const auto& [arguments, message] : cases) {
    const auto run = model.run(arguments);
    INFO(arguments << "\n" << run.err);
    CHECK(run.exitCode == 1);
    CHECK(run.err.find(message) != std::string::npos);
    CHECK_FALSE(fs::exists(model.temp.path() / "p.ecorche"));
  }
  CHECK(model.run(kNew + "--symmetry sideways -o p.ecorche").exitCode == 2);
  CHECK(model.run(kNew + "--unit furlong -o p.ecorche").exitCode == 2);
  CHECK(model.run("new -o p.ecorche").exitCode == 2);
}

TEST_CASE("a skin that was laid around bones is no bone when new runs again") {
  Model model;
  fs::rename(model.temp.path() / "meshes" / "bones" / "BONEhumerus.obj",
             model.temp.path() / "humerus.obj");
  const std::string command = "new --bones . --unit cm --symmetry none -o arm.ecorche --json";
  REQUIRE(model.run(command).exitCode == 0);
  REQUIRE(fs::exists(model.temp.path() / "arm-skin.obj"));
  const auto again = model.run(command + " --force");
  INFO(again.err << again.out);
  REQUIRE(again.exitCode == 0);
  const auto json = nlohmann::json::parse(again.out);
  CHECK(json.at("bones") == 1);
  CHECK(std::ranges::any_of(json.at("findings"),
                            [](const auto& f) { return f.at("kind") == "made-skin"; }));
  // Nor is that of another project; a file of such a name without a project is
  REQUIRE(model.run("new --bones . --unit cm --symmetry none -o leg.ecorche").exitCode == 0);
  CHECK(model::loadProject(model.temp.path() / "leg.ecorche").value().bones.size() == 1);
  fs::remove(model.temp.path() / "arm.ecorche");
  REQUIRE(model.run("new --bones . --unit cm --symmetry none -o rest.ecorche").exitCode == 0);
  CHECK(model::loadProject(model.temp.path() / "rest.ecorche").value().bones.size() == 2);
}

TEST_CASE("parts of one name in one file are all there") {
  Model model;
  const auto solid = [](double x) {
    const auto p = [&](int v) {
      return fmt::format("{} {} {}", x + 0.01 * (v & 1), 0.01 * (v >> 1 & 1), 0.01 * (v >> 2));
    };
    std::string out = "solid rib\n";
    for (const auto& [a, b, c] : {std::array{0, 2, 1}, {0, 1, 4}, {0, 4, 2}, {1, 2, 4}}) {
      out += fmt::format(
          "facet normal 0 0 0\nouter loop\nvertex {}\nvertex {}\nvertex {}\n"
          "endloop\nendfacet\n",
          p(a), p(b), p(c));
    }
    return out + "endsolid rib\n";
  };
  model.write("ribs.stl", solid(0) + solid(0.05) + solid(-0.05));
  const auto run = model.run(
      "new --skin meshes/skin.obj --bones ribs.stl --unit cm --symmetry none "
      "-o p.ecorche --json");
  INFO(run.err);
  REQUIRE(run.exitCode == 0);
  const auto project = model::loadProject(model.temp.path() / "p.ecorche").value();
  REQUIRE(project.bones.size() == 3);
  CHECK(project.bones[1].name == "rib_2");
  CHECK(project.bones[1].mesh.part == "rib_2");
  // Each stands where its part does
  const auto check = nlohmann::json::parse(model.run("check p.ecorche --json").out);
  CHECK(check.at("meshes").size() == 4);
  for (const auto& f : check.at("between")) CHECK(f.at("kind") != "within");
}

TEST_CASE("an interrupted command answers 130 and writes nothing") {
  Model model;
  REQUIRE(model.run(kNew + "-o p.ecorche").exitCode == 0);
  // Waits for a script that never comes; the signal finds it there
  model.write(
      "interrupt.sh",
      fmt::format(
          "mkfifo never\nexec 3<>never\n'{}/ecorche' run p.ecorche - -o q.ecorche <&3 & pid=$!\n"
          "sleep 0.5\nkill -INT $pid\nwait $pid\n",
          ECORCHE_BIN_DIR));
  const int status = std::system(
      fmt::format("cd '{}' && sh interrupt.sh 2>err", model.temp.path().string()).c_str());
  CHECK(WEXITSTATUS(status) == 130);
  CHECK_FALSE(fs::exists(model.temp.path() / "q.ecorche"));
  CHECK(readFile(model.temp.path() / "err").value().find("interrupted") != std::string::npos);
}
