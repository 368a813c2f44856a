// The way of a mesh in: what `check` says about it, what `repair` does to it, what `new` makes
// where there is no skin or no bone.

#include <ecorche/mesh/read_mesh.h>
#include <ecorche/model/project_file.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "support/program.h"
#include "support/small_project.h"

using namespace ecorche;
using Json = nlohmann::json;
using mesh::Vector3;
using test::SmallProject;

namespace {

mesh::SurfaceMesh ball(const Vector3& at, double radius) { return test::sphere(at, radius, 3); }

/// Without the end above this height [m], as a scan ends.
mesh::SurfaceMesh openAbove(mesh::SurfaceMesh m, double z) {
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < m.F.rows(); ++f) {
    double middle = 0.0;
    for (int c = 0; c < 3; ++c) middle += m.V(m.F(f, c), 2) / 3;
    if (middle < z) m.F.row(kept++) = m.F.row(f);
  }
  m.F.conservativeResize(kept, 3);
  return m;
}

mesh::SurfaceMesh skin() { return SmallProject::egg(SmallProject::kSkin, 3); }

Json checked(const SmallProject& p, const std::string& what) {
  const auto run = test::runEcorche("check " + what + " --json --quiet", p.folder());
  INFO(run.err);
  REQUIRE(run.exitCode == 0);
  return Json::parse(run.out);
}

/// Every finding of that kind, of a mesh or between meshes.
std::vector<Json> findingsOf(const Json& check, const std::string& kind) {
  std::vector<Json> out;
  const auto gather = [&](const Json& list) {
    for (const Json& f : list) {
      if (f.at("kind") == kind) out.push_back(f);
    }
  };
  for (const Json& mesh : check.at("meshes")) gather(mesh.at("findings"));
  gather(check.at("between"));
  return out;
}

/// Builds, and proves what was built.
Json built(const SmallProject& p, const std::string& project = "limb.ecorche") {
  const auto run = test::runEcorche(
      "build " + project + " -o out --no-preview --no-cache --quiet --json", p.folder());
  INFO(run.err);
  REQUIRE(run.exitCode == 0);
  const auto check = test::runEcorche("check out", p.folder());
  INFO(check.out);
  CHECK(check.exitCode == 0);
  return Json::parse(run.out);
}

bool told(const Json& report, const std::string& kind) {
  return std::ranges::any_of(report.at("findings"),
                             [&](const Json& f) { return f.at("kind") == kind; });
}

}  // namespace

TEST_CASE("check: every finding has a severity, a place, a size and what is done about it") {
  const SmallProject p;
  p.write("skin.obj", openAbove(skin(), 0.1));
  const Json check = checked(p, "limb.ecorche");
  REQUIRE(check.at("meshes").size() == 2);
  CHECK(check.at("meshes")[0].at("closed") == false);
  CHECK(check.at("meshes")[1].at("closed") == true);
  const auto holes = findingsOf(check, "hole");
  REQUIRE(holes.size() == 1);
  CHECK(holes[0].at("severity") == "error");
  CHECK(holes[0].at("size").get<double>() == Approx(0.1).epsilon(0.2));
  CHECK(holes[0].at("point_m")[2].get<double>() == Approx(0.1).margin(0.02));
  CHECK(holes[0].at("remedy").get<std::string>().find("fill-holes") != std::string::npos);
  CHECK(check.at("counts").at("error") == 1);

  const auto table = test::runEcorche("check limb.ecorche", p.folder());
  CHECK(table.exitCode == 0);
  CHECK(table.out.find("error: skin: hole at") != std::string::npos);
  CHECK(table.out.find("fill-holes") != std::string::npos);
}

TEST_CASE("check: bones that overlap, touch, poke out, lie within one another") {
  const SmallProject p;
  p.write("bone.obj", ball({0, 0, 0}, 0.02));
  p.write("overlap.obj", ball({0, 0, 0.03}, 0.02));
  p.write("within.obj", ball({0, 0, -0.005}, 0.01));
  p.write("out.obj", ball({0.05, 0, 0}, 0.01));
  p.write("near.obj", ball({0, 0, -0.0351}, 0.015));
  p.write("limb.ecorche",
          SmallProject::textWith(R"("file": "bone.obj"})",
                                 R"("file": "bone.obj"}, {"name": "b", "file": "overlap.obj"},
                                 {"name": "c", "file": "within.obj"}, {"name": "d", "file": "out.obj"},
                                 {"name": "e", "file": "near.obj"})"));
  const Json check = checked(p, "limb.ecorche");

  const auto overlaps = findingsOf(check, "overlap");
  REQUIRE(overlaps.size() == 1);
  // A lens of two balls of radius r, d apart
  const double r = 0.02, d = 0.03;
  const double lens = 3.14159265 * (4 * r + d) * (2 * r - d) * (2 * r - d) / 12;
  CHECK(overlaps[0].at("size").get<double>() == Approx(lens).epsilon(0.1));
  CHECK(overlaps[0].at("message").get<std::string>().find("\"b\"") != std::string::npos);
  CHECK(findingsOf(check, "within").size() == 1);
  const auto touching = findingsOf(check, "touch");
  REQUIRE(touching.size() == 1);
  CHECK(touching[0].at("size").get<double>() == Approx(1e-4).epsilon(0.5));
  const auto out = findingsOf(check, "pokes-out");
  REQUIRE(out.size() == 1);
  CHECK(out[0].at("object") == "d");
  const double half = 0.5 * 4.18879 * 1e-6;
  CHECK(out[0].at("size").get<double>() == Approx(half).epsilon(0.25));
}

TEST_CASE("check and build: what reaches out of the skin beyond a cut plane is nobody's concern") {
  const SmallProject p;
  p.write("out.obj", ball({0.05, 0, 0}, 0.01));
  const std::string bones = R"("file": "bone.obj"}, {"name": "spur", "file": "out.obj"})";
  const auto planes = [](int side) {
    return fmt::format(
        R"(], "cut_planes": [{{"name": "side", "kind": "region", "point": [0, 0, 0],
           "normal": [{}, 0, 0]}}],
  "settings")",
        side);
  };
  for (const int side : {1, -1}) {
    INFO("the plane keeps the side of x " << side);
    std::string text = SmallProject::textWith(R"("file": "bone.obj"})", bones);
    const std::string end = "],\n  \"settings\"";
    const auto spot = text.find(end);
    REQUIRE(spot != std::string::npos);
    p.write("limb.ecorche", text.replace(spot, end.size(), planes(side)));
    CHECK(findingsOf(checked(p, "limb.ecorche"), "pokes-out").size() == (side > 0 ? 1 : 0));
  }
}

TEST_CASE("check and build: bones in another unit are named with the factor and the way out") {
  const SmallProject p;
  mesh::SurfaceMesh bone = SmallProject::egg(SmallProject::kBone, 2);
  bone.V *= 1000.0;
  p.write("bone.obj", bone);
  const auto units = findingsOf(checked(p, "limb.ecorche"), "units");
  REQUIRE(units.size() == 1);
  CHECK(units[0].at("severity") == "error");
  CHECK(units[0].at("size").get<double>() == 1000.0);
  const std::string message = units[0].at("message");
  for (const char* word : {"\"humerus\"", "skin", "1000", "millimetres", "\"unit\""}) {
    INFO(word);
    CHECK(message.find(word) != std::string::npos);
  }
  const auto run = test::runEcorche("build limb.ecorche -o out --quiet --json", p.folder());
  CHECK(run.exitCode == 1);
  CHECK(Json::parse(run.out).at("error").at("code") == "UnitsDiffer");
  // The way out
  p.write("limb.ecorche",
          SmallProject::textWith(R"("file": "bone.obj")", R"("file": "bone.obj", "unit": "mm")"));
  CHECK_FALSE(told(built(p), "units"));
}

TEST_CASE("repair: an open skin is capped or wrapped on request, with the deviation stated") {
  const SmallProject p;
  p.write("skin.obj", openAbove(skin(), 0.12));
  const std::string how = GENERATE("fill-holes", "wrap");
  INFO(how);
  p.write("limb.ecorche",
          SmallProject::textWith(R"("file": "skin.obj")",
                                 R"("file": "skin.obj", "repair": ")" + how + "\""));
  const Json report = built(p);
  CHECK(told(report, how == "wrap" ? "wrap" : "hole"));
}

TEST_CASE("repair: a hollow skin becomes solid with outer-hull") {
  const SmallProject p;
  mesh::SurfaceMesh inner = skin();
  inner.V *= 0.95;
  inner.F.col(1).swap(inner.F.col(2));
  mesh::SurfaceMesh shell = mesh::joined({skin(), inner}, "shell");
  shell.parts.clear();
  p.write("skin.obj", shell);
  const auto refused =
      test::runEcorche("build limb.ecorche -o out --quiet --json --no-cache", p.folder());
  CHECK(refused.exitCode == 1);
  CHECK(refused.err.find("outer-hull") != std::string::npos);
  p.write("limb.ecorche", SmallProject::textWith(R"("file": "skin.obj")",
                                                 R"("file": "skin.obj", "repair": "outer-hull")"));
  const Json report = built(p);
  CHECK(told(report, "outer-hull"));
  const double volume = report.at("domain").at("volume_cm3");
  const mesh::SurfaceMesh bone = SmallProject::egg(SmallProject::kBone, 2);
  CHECK(volume ==
        Approx(1e6 * (mesh::signedVolume(skin().V, skin().F) - mesh::signedVolume(bone.V, bone.F)))
            .epsilon(0.01));
}

TEST_CASE("new without a skin lays one around the bones; build makes muscles under it") {
  const SmallProject p;
  const auto run = test::runEcorche(
      "new --bones bone.obj --offset 0.03 --symmetry none -o fossil.ecorche --json", p.folder());
  INFO(run.err);
  REQUIRE(run.exitCode == 0);
  const auto made = mesh::readMesh(p.at("fossil-skin.obj"), {}, *std::make_unique<RunContext>());
  REQUIRE(made);
  const mesh::SurfaceMesh bone = SmallProject::egg(SmallProject::kBone, 2);
  const mesh::Box inner = mesh::boundingBox(bone), outer = mesh::boundingBox(*made);
  for (int k = 0; k < 3; ++k) {
    CHECK(outer.hi[k] - inner.hi[k] == Approx(0.03).epsilon(0.1));
    CHECK(inner.lo[k] - outer.lo[k] == Approx(0.03).epsilon(0.1));
  }
  // The bones' own muscles fit in there
  auto project = model::loadProject(p.at("limb.ecorche")).value();
  project.skin = model::loadProject(p.at("fossil.ecorche")).value().skin;
  REQUIRE(model::saveProject(project, p.at("whole.ecorche")));
  built(p, "whole.ecorche");

  const auto again =
      test::runEcorche("new --bones bone.obj --symmetry none -o fossil.ecorche", p.folder());
  CHECK(again.exitCode == 1);
  CHECK(test::runEcorche("new -o nothing.ecorche", p.folder()).exitCode == 2);
}

TEST_CASE("a project without bones builds with curves that end free or on a cut plane") {
  const SmallProject p;
  const auto run =
      test::runEcorche("new --skin skin.obj --symmetry none -o worm.ecorche", p.folder());
  INFO(run.err);
  REQUIRE(run.exitCode == 0);
  p.write("worm.ecorche", R"({
  "schema": 1, "unit": "m", "skin": {"file": "skin.obj"},
  "cut_planes": [{"name": "end", "kind": "region", "point": [0, 0, 0.05], "normal": [0, 0, -1]}],
  "settings": {"tets": 8000},
  "tissues": [
    {"name": "long", "kind": "muscle",
     "curves": [{"points": [{"at": [0.02, 0, 0.05]}, {"at": [0.02, 0, -0.08]}],
                 "start": {"on": "plane", "name": "end"}}]},
    {"name": "free", "kind": "muscle",
     "curves": [{"points": [{"at": [-0.02, 0, 0.02]}, {"at": [-0.02, 0, -0.08]}]}]}
  ]})");
  const Json report = built(p, "worm.ecorche");
  CHECK(report.at("tissues").size() == 3);
}

TEST_CASE("obstacles are wrapped around and exported as they are; cavities are left out") {
  const SmallProject p;
  p.write("liver.obj", ball({0.026, 0, 0.06}, 0.011));
  p.write("bladder.obj", ball({-0.026, 0, 0.06}, 0.011));
  p.write("limb.ecorche", SmallProject::textWith(R"("tissues": [)", R"("tissues": [
    {"name": "liver", "kind": "obstacle", "file": "liver.obj"},
    {"name": "bladder", "kind": "cavity", "file": "bladder.obj"},)"));
  const Json report = built(p);
  const auto volume = [&](const std::string& file) {
    const auto m = mesh::readMesh(p.at(file), {}, *std::make_unique<RunContext>());
    REQUIRE(m);
    return mesh::signedVolume(m->V, m->F);
  };
  const double given = volume("liver.obj");
  CHECK(volume("out/others/liver.obj") == Approx(given).epsilon(1e-6));
  const double whole = volume("skin.obj") - volume("bone.obj") - 2 * given;
  CHECK(report.at("domain").at("volume_cm3").get<double>() == Approx(1e6 * whole).epsilon(0.01));
  // No muscle reaches into them
  for (const char* muscle : {"out/muscles/flexor.obj", "out/muscles/extensor.obj"}) {
    const auto m = mesh::readMesh(p.at(muscle), {}, *std::make_unique<RunContext>());
    REQUIRE(m);
    double nearest = 1.0;
    for (Eigen::Index v = 0; v < m->V.rows(); ++v) {
      for (const double side : {0.026, -0.026})
        nearest = std::min(nearest, (m->V.row(v).transpose() - Vector3(side, 0, 0.06)).norm());
    }
    CHECK(nearest > 0.0102);
  }
}

TEST_CASE("build tells what it will take, and refuses what the machine cannot hold") {
  const SmallProject p;
  const auto run =
      test::runEcorche("build limb.ecorche -o out --no-preview --no-cache", p.folder());
  CHECK(run.exitCode == 0);
  CHECK(run.err.find("estimate: about 8 k tets, ") != std::string::npos);
  const auto refused = test::runEcorche("build limb.ecorche -o out --tets 2M --json --no-cache",
                                        p.folder(), "export ECORCHE_MEMORY=2000000000;");
  CHECK(refused.exitCode == 1);
  CHECK(Json::parse(refused.out).at("error").at("code") == "OutOfMemory");
  CHECK(refused.err.find("--tets ") != std::string::npos);
}
