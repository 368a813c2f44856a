// What `ecorche build` answers to faulty input: exact code, exit 1, one sentence, nothing written.

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "support/program.h"
#include "support/refusal.h"
#include "support/small_project.h"

using namespace ecorche;
using test::SmallProject;
namespace fs = std::filesystem;

namespace {

std::set<std::string> everythingIn(const fs::path& folder) {
  std::set<std::string> out;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    out.insert(entry.path().string());
  return out;
}

test::Outcome build(const SmallProject& p, const std::string& arguments,
                    const std::string& first = {}) {
  return test::runEcorche("build " + arguments + " --no-preview --no-cache --quiet --json",
                          p.folder(), first);
}

/// Builds and demands a refusal that leaves the disk as it was.
/// @param words  what the sentence must say, among other things
void refuses(const SmallProject& p, const std::string& code, const std::vector<std::string>& words,
             const std::string& output = "made/for/this/out", const std::string& first = {}) {
  const auto before = everythingIn(p.folder());
  const auto run = build(p, "limb.ecorche -o " + output, first);
  CHECK(everythingIn(p.folder()) == before);
  requireRefused(run, code, words);
}

std::string replaced(std::string text, const std::string& old, const std::string& fresh) {
  const auto spot = text.find(old);
  REQUIRE(spot != std::string::npos);
  return text.replace(spot, old.size(), fresh);
}

}  // namespace

TEST_CASE("build makes a folder that check passes, and replaces only its own") {
  const SmallProject p;
  auto run = build(p, "limb.ecorche -o out");
  INFO(run.err);
  REQUIRE(run.exitCode == 0);
  CHECK(nlohmann::json::parse(run.out).contains("tissues"));
  for (const char* file :
       {"anatomy.vtu", "anatomy.mesh", "muscles/flexor.obj", "muscles/extensor.obj",
        "bones/humerus.obj", "fat.obj", "skin.obj", "model.json", "report.json"})
    CHECK(fs::is_regular_file(p.at("out") / file));
  const auto check = test::runEcorche("check out", p.folder());
  INFO(check.out);
  CHECK(check.exitCode == 0);

  run = build(p, "limb.ecorche -o out --formats vtu");
  CHECK(run.exitCode == 0);
  CHECK_FALSE(fs::exists(p.at("out/anatomy.mesh")));
  p.write("out/notes.txt", "mine");
  refuses(p, "FileNotWritable", {"out: ", "\"notes.txt\"", "name a new folder"}, "out");
  refuses(p, "FileNotWritable", {"\"bone.obj\"", "name a new folder"}, ".");
}

TEST_CASE("build: a file that is missing") {
  SECTION("the project") {
    const SmallProject p;
    fs::remove(p.at("limb.ecorche"));
    refuses(p, "FileMissing", {"limb.ecorche: there is no such file; check the path"});
  }
  SECTION("a mesh") {
    const SmallProject p;
    fs::remove(p.at("bone.obj"));
    refuses(p, "FileMissing",
            {"bone.obj: bone \"humerus\": there is no such file", "project's folder"});
  }
  SECTION("a part of a mesh") {
    const SmallProject p;
    p.write("limb.ecorche",
            SmallProject::textWith("\"bone.obj\"", R"("bone.obj", "part": "ulna")"));
    refuses(p, "UnknownName", {"bone.obj: ", "\"humerus\"", "\"ulna\""});
  }
}

TEST_CASE("build: a file that is empty") {
  const SmallProject p;
  const std::string file = GENERATE("limb.ecorche", "skin.obj");
  p.write(file, std::string());
  refuses(p, "FileEmpty", {file + ": ", "the file is empty; export it again"});
}

TEST_CASE("build: a file that is truncated") {
  const SmallProject p;
  SECTION("the project") {
    p.write("limb.ecorche", SmallProject::text().substr(0, 300));
    refuses(p, "FileTruncated", {"limb.ecorche:10:", "breaks off"});
  }
  SECTION("text") {
    const std::string whole = readFile(p.at("skin.obj")).value();
    p.write("skin.obj", whole.substr(0, whole.rfind(' ', 2000)));
    refuses(p, "FileTruncated", {"skin.obj:", "skin: the file breaks off here", "export it again"});
  }
  SECTION("binary") {
    const mesh::SurfaceMesh bone = SmallProject::egg(SmallProject::kBone, 2);
    REQUIRE(mesh::writeStl(bone, p.at("bone.stl")));
    const std::string whole = readFile(p.at("bone.stl")).value();
    p.write("bone.stl", whole.substr(0, whole.size() / 2));
    p.write("limb.ecorche", SmallProject::textWith("bone.obj", "bone.stl"));
    refuses(p, "FileTruncated",
            {"bone.stl: bone \"humerus\": the file breaks off", "export it again"});
  }
}

TEST_CASE("build: a file that is something else") {
  const SmallProject p;
  const std::string letter = "Dear reader,\nthis is a letter.\n";
  SECTION("the project") {
    p.write("limb.ecorche", letter);
    refuses(p, "FileUnknownFormat", {"limb.ecorche:1:1: this is no project file", "ecorche new"});
  }
  SECTION("a mesh") {
    p.write("skin.txt", letter);
    p.write("limb.ecorche", SmallProject::textWith("skin.obj", "skin.txt"));
    refuses(p, "FileUnknownFormat", {"skin.txt: skin: ", "OBJ, PLY, STL, OFF, GLB, glTF and FBX"});
  }
}

TEST_CASE("build: a vertex that is not a number") {
  const SmallProject p;
  std::string text = readFile(p.at("skin.obj")).value();
  const auto line = text.find("\nv ", 200) + 1;
  text.replace(line, text.find('\n', line) - line, "v 0.01 nan 0.02");
  p.write("skin.obj", text);
  const auto number = std::count(text.begin(), text.begin() + std::ptrdiff_t(line), '\n') + 1;
  refuses(p, "NonFiniteVertex",
          {fmt::format("skin.obj:{}: skin: ", number), "nan", "remove or place it"});
}

TEST_CASE("build: a skin with a large hole") {
  const SmallProject p;
  mesh::SurfaceMesh skin = SmallProject::egg(SmallProject::kSkin, 3);
  Eigen::Index kept = 0;
  for (Eigen::Index f = 0; f < skin.F.rows(); ++f) {
    double z = 0.0;
    for (int c = 0; c < 3; ++c) z += skin.V(skin.F(f, c), 2) / 3;
    if (z < 0.1) skin.F.row(kept++) = skin.F.row(f);
  }
  skin.F.conservativeResize(kept, 3);
  p.write("skin.obj", skin);
  refuses(p, "SkinNotClosed", {"\"skin\" has a hole of", "m across; close it", " m)"});
}

TEST_CASE("build: bones only outside the skin") {
  const SmallProject p;
  mesh::SurfaceMesh bone = SmallProject::egg(SmallProject::kBone, 2);
  bone.V.col(0).array() += 1.0;
  p.write("bone.obj", bone);
  refuses(p, "BonesOutsideSkin", {"outside the skin", "check the units"});
}

TEST_CASE("build: a muscle without curve") {
  const SmallProject p;
  std::string text = SmallProject::text();
  const auto begin = text.find("\"curves\""), end = text.find("}}]}", begin) + 3;
  p.write("limb.ecorche", text.replace(begin, end - begin, "\"curves\": []"));
  refuses(p, "MuscleWithoutCurve", {"limb.ecorche:9:5: muscle \"flexor\" has no curve; draw one"});
}

TEST_CASE("build: a curve of no length") {
  const SmallProject p;
  std::string text = SmallProject::text();
  for (const char* point : {"0.026, 0, 0", "0.006, 0, 0.08"})
    text = replaced(text, point, "0.006, 0, -0.08");
  p.write("limb.ecorche", text);
  refuses(p, "ZeroLengthCurve",
          {"limb.ecorche:10:", "\"flexor\" has no length; move its ends apart"});
}

TEST_CASE("build: a curve that leaves the skin") {
  const SmallProject p;
  p.write("limb.ecorche", SmallProject::textWith("0.026, 0, 0", "0.076, 0, 0"));
  refuses(p, "CurveOutsideSkin",
          {"limb.ecorche: \"flexor\" leaves the skin by 26", "move its control points inside",
           "(at 0.076, 0,"});
}

TEST_CASE("build: two things of one name") {
  const SmallProject p;
  SECTION("muscles") {
    p.write("limb.ecorche", SmallProject::textWith("\"flexor\"", "\"extensor\""));
    refuses(p, "DuplicateName",
            {"limb.ecorche:12:", "two tissues are called \"extensor\"", "rename one"});
  }
  SECTION("bones") {
    p.write("limb.ecorche",
            SmallProject::textWith("\"bones\": [",
                                   R"("bones": [{"name": "humerus", "file": "b.obj"}, )"));
    refuses(p, "DuplicateName",
            {"limb.ecorche:6:", "two bones are called \"humerus\"", "rename one"});
  }
}

TEST_CASE("build: a key that nobody knows") {
  const SmallProject p;
  p.write("limb.ecorche", SmallProject::textWith("\"fat\": 0.3", "\"fatness\": 0.3"));
  refuses(p, "UnknownKey",
          {"limb.ecorche:7:16: the settings has no \"fatness\"", "fat, core_radius"});
}

TEST_CASE("build: a project of a newer program") {
  const SmallProject p;
  p.write("limb.ecorche", SmallProject::textWith("\"schema\": 1", "\"schema\": 7"));
  refuses(p, "SchemaTooNew", {"limb.ecorche:2:13: ", "schema 7", "update this program"});
}

TEST_CASE("build: an output that cannot be written") {
  const SmallProject p;
  refuses(p, "FileNotWritable", {"skin.obj: the output is a file"}, "skin.obj");
  refuses(p, "FileNotWritable", {"skin.obj/deep/out: ", "Not a directory", "write elsewhere"},
          "skin.obj/deep/out");
  refuses(p, "FileNotWritable", {"/proc/out: nothing can be created in /proc"}, "/proc/out");
  refuses(p, "FileNotWritable", {"name a folder"}, "''");
  refuses(p, "FileNotWritable", {"/: "}, "/");
  if (::geteuid() != 0) {
    fs::create_directory(p.at("locked"));
    fs::permissions(p.at("locked"), fs::perms::owner_read | fs::perms::owner_exec);
    refuses(p, "FileNotWritable", {"locked/out: ", "Permission denied"}, "locked/out");
  }
}

TEST_CASE("build: a disk that is full") {
  // A limit to the size of files is the nearest thing that every machine has. In blocks of 512
  // bytes; the first is too small for what the mesher is given, the second for the tets
  const SmallProject p;
  for (const char* limit : {"ulimit -f 40;", "ulimit -f 1000;"}) {
    INFO(limit);
    refuses(p, "FileNotWritable",
            {"cannot write the file: File too large; choose another folder or free some space"},
            "made/for/this/out", limit);
  }
}
