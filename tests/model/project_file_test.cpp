#include <ecorche/core/files.h>
#include <ecorche/model/json.h>
#include <ecorche/model/migrations.h>
#include <ecorche/model/project_check.h>
#include <ecorche/model/project_file.h>

#include <catch2/catch.hpp>
#include <numbers>

#include "model/sample_project.h"
#include "support/paths.h"

using namespace ecorche;
using namespace ecorche::model;

namespace {

/// What the loader says of a text, in the words that a user sees.
Error refusalOf(std::string_view text) {
  const auto project = parseProject(text, "forearm.ecorche");
  REQUIRE_FALSE(project);
  return project.error();
}

struct BadCase {
  const char* what;
  std::string text;
  ErrorCode code;
  const char* message;
};

}  // namespace

TEST_CASE("a project file is read into metres") {
  const auto project = parseProject(test::kFullProject, "some/folder/forearm.ecorche");
  REQUIRE(project);
  CHECK(project->name == "forearm");
  CHECK(project->folder == "some/folder");
  CHECK(meshPath(*project, project->skin) == "some/folder/skin.obj");
  CHECK(metresPerUnit(*project, project->skin) == 0.001);
  CHECK(metresPerUnit(*project, project->bones[0].mesh) == 0.01);
  CHECK(project->cutPlanes[1].point == Vector3(-0.2, 0, 0));
  CHECK(project->settings.coreRadius == 0.0015);
  CHECK(project->settings.tets == 200000);

  const Tissue& biceps = project->tissues[*findTissue(*project, "biceps")];
  CHECK(biceps.curves[0].points[1] == ControlPoint{{0.025, 0.03, 0.05}, 1.25});
  CHECK(biceps.curves[1].end == Support{Support::On::Tissue, "belly"});
  CHECK(biceps.anisotropy.rotation == Approx(std::numbers::pi / 6).epsilon(1e-15));
  CHECK(biceps.colour == Colour{0xc0, 0x50, 0x4d});
  CHECK(biceps.coreRadius == 0.001);
  CHECK(biceps.layer == 1);
  CHECK(biceps.keepsTwin);
  CHECK_FALSE(biceps.isProtected);
  CHECK(biceps.side == Side::Left);
  CHECK(biceps.attachments[1].patch->part == "tuberosity");
  CHECK(biceps.attachments[1].role == Attachment::Role::Insertion);
  CHECK(curveLabel(biceps, 1) == "\"biceps\", curve 2 (short head)");
  CHECK(splineOf(biceps.curves[0]).at(2.0) == Vector3(0.04, 0.04, 0.08));
}

TEST_CASE("ids: fat is 1, muscles and fillers count from 2 in file order, meshes have none") {
  const auto project = parseProject(test::kFullProject, "a.ecorche");
  REQUIRE(project);
  CHECK(tissueId(*project, 0) == kFat);
  CHECK(tissueId(*project, 1) == TissueId(2));
  CHECK(tissueId(*project, 2) == TissueId(3));
  CHECK(tissueId(*project, 3) == kNoTissue);
  CHECK(tissueId(*project, 4) == kNoTissue);
}

TEST_CASE("what is written is what was read, byte for byte") {
  const auto project = parseProject(test::kFullProject, "forearm.ecorche");
  REQUIRE(project);
  CHECK(projectText(*project) == test::kFullProject);
}

TEST_CASE("saving and loading gives the same project in every unit") {
  test::TempFolder temp;
  Project project = parseProject(test::kFullProject, temp.path() / "p.ecorche").value();
  project.tissues[1].curves[0].points[0].at = Vector3(1.0 / 3.0, -1e-7 / 7.0, 12345.678901234567);
  for (Unit unit : {Unit::Metre, Unit::Decimetre, Unit::Centimetre, Unit::Millimetre, Unit::Inch}) {
    project.unit = unit;
    REQUIRE(saveProject(project, temp.path() / "p.ecorche"));
    auto again = loadProject(temp.path() / "p.ecorche");
    REQUIRE(again);
    if (unit == Unit::Inch) {
      // Not every double is a multiple of 0.0254 in doubles: near, and at rest from then on
      CHECK((again->tissues[1].curves[0].points[0].at - project.tissues[1].curves[0].points[0].at)
                .norm() < 1e-11);
      CHECK(projectText(*again) == projectText(project));
    } else {
      CHECK(*again == project);
    }
  }
}

TEST_CASE("a muscle without a curve is named with its line and column") {
  const Error error = refusalOf(R"({
  "schema": 1, "skin": {"file": "skin.obj"},
  "tissues": [
    {"name": "triceps", "kind": "muscle", "curves": [{"points": [{"at": [0,0,0]}, {"at": [0,0,1]}]}]},
          {"name": "biceps", "kind": "muscle"}
  ]
})");
  CHECK(error.code == ErrorCode::MuscleWithoutCurve);
  CHECK(error.text() ==
        "forearm.ecorche:5:11: muscle \"biceps\" has no curve; draw one or delete the muscle");
  CHECK(error.place.object == "biceps");
}

TEST_CASE("every fault of a project file has its own code and a place") {
  using test::fullProjectWith;
  const std::vector<BadCase> cases = {
      {"empty", "", ErrorCode::FileEmpty, "forearm.ecorche: the file is empty"},
      {"blank", " \n ", ErrorCode::FileEmpty, "is empty"},
      {"cut off", std::string(test::kFullProject.substr(0, 500)), ErrorCode::FileTruncated,
       "forearm.ecorche:14:44: the file breaks off here"},
      {"comma", fullProjectWith("\"name\": \"forearm\",", "\"name\": \"forearm\""),
       ErrorCode::FileSyntax, "forearm.ecorche:4:3: this is not JSON"},
      {"text behind", std::string(test::kFullProject) + "x", ErrorCode::FileSyntax,
       "forearm.ecorche:74:1: this is not JSON"},
      {"deep", std::string(100000, '['), ErrorCode::FileSyntax, "64 deep"},
      {"overflow", fullProjectWith("0.25", "1e999"), ErrorCode::FileSyntax,
       "forearm.ecorche:14:23: "},
      {"not an object", "[1]", ErrorCode::WrongType, "forearm.ecorche:1:1: a project is an object"},
      {"key twice", fullProjectWith("\"name\": \"forearm\"", "\"unit\": \"cm\""),
       ErrorCode::DuplicateName, "forearm.ecorche:4:3: the key \"unit\" is given twice"},
      {"no schema", fullProjectWith("\"schema\": 1,", ""), ErrorCode::MissingKey,
       "\"schema\" is missing"},
      {"newer", fullProjectWith("\"schema\": 1,", "\"schema\": 2, \"hair\": [],"),
       ErrorCode::SchemaTooNew,
       "forearm.ecorche:2:13: the project was written by a newer program (schema 2, this one knows "
       "1)"},
      {"schema 0", fullProjectWith("\"schema\": 1", "\"schema\": 0"), ErrorCode::ValueOutOfRange,
       "no schema 0"},
      {"schema text", fullProjectWith("\"schema\": 1", "\"schema\": \"1\""), ErrorCode::WrongType,
       "whole number"},
      {"no skin",
       fullProjectWith("\"skin\": {\"file\": \"skin.obj\", \"part\": \"body\", \"unit\": \"mm\"},",
                       ""),
       ErrorCode::MissingKey, "forearm.ecorche:1:1: the project lacks \"skin\""},
      {"unknown key", fullProjectWith("\"layer\"", "\"lair\""), ErrorCode::UnknownKey,
       "forearm.ecorche:22:7: muscle \"biceps\" has no \"lair\"; it may have name, kind"},
      {"key of another kind", fullProjectWith("\"file\": \"spleen.obj\"", "\"curves\": []"),
       ErrorCode::UnknownKey, "obstacle \"spleen\" has no \"curves\""},
      {"missing key", fullProjectWith("\"name\": \"humerus\", ", ""), ErrorCode::MissingKey,
       "forearm.ecorche:7:5: a bone lacks \"name\""},
      {"no kind", fullProjectWith("\"kind\": \"filler\",", ""), ErrorCode::MissingKey,
       "tissue \"belly\" lacks \"kind\""},
      {"wrong type", fullProjectWith("\"group\": \"arm\"", "\"group\": 7"), ErrorCode::WrongType,
       "forearm.ecorche:21:16: \"group\" is a number; it must be a text"},
      {"two numbers", fullProjectWith("[2.5, 3, 5]", "[2.5, 3]"), ErrorCode::WrongType,
       "must be [x, y, z]"},
      {"half a tet", fullProjectWith("200000", "200000.5"), ErrorCode::WrongType,
       "forearm.ecorche:14:58: "},
      {"few tets", fullProjectWith("200000", "7"), ErrorCode::ValueOutOfRange, "tets is 7"},
      {"negative fat", fullProjectWith("0.25", "-0.25"), ErrorCode::ValueOutOfRange,
       "forearm.ecorche:14:23: fat is -0.25"},
      {"unit", fullProjectWith("\"cm\"", "\"furlong\""), ErrorCode::ValueOutOfRange,
       "must be m, dm, cm, mm or in"},
      {"kind", fullProjectWith("\"filler\"", "\"brain\""), ErrorCode::ValueOutOfRange,
       "must be muscle, filler, obstacle, cavity or fat"},
      {"colour", fullProjectWith("#c0504d", "red"), ErrorCode::ValueOutOfRange, "\"#c0504d\""},
      {"both sizes", fullProjectWith("\"fat\": 0.25", "\"edge_length\": 1"),
       ErrorCode::ValueOutOfRange, "exclude each other"},
      {"normal", fullProjectWith("[-1, 0, 0]", "[0, 0, 0]"), ErrorCode::ValueOutOfRange,
       "forearm.ecorche:12:73: "},
      {"far away", fullProjectWith("[2.5, 3, 5]", "[2.5, 3, 5e9]"), ErrorCode::ValueOutOfRange,
       "check the unit"},
      {"tissue value", fullProjectWith("1.25", "0"), ErrorCode::ValueOutOfRange,
       "forearm.ecorche:32:43: the tissue value of control point 2 of \"biceps\", curve 1 (long "
       "head) is 0"},
      {"two bones", fullProjectWith("\"name\": \"radius\"", "\"name\": \"humerus\""),
       ErrorCode::DuplicateName,
       "forearm.ecorche:8:14: two bones are called \"humerus\" (numbers 1 and 2)"},
      {"two tissues", fullProjectWith("\"name\": \"spleen\"", "\"name\": \"biceps\""),
       ErrorCode::DuplicateName, "two tissues"},
      {"two heads", fullProjectWith("short head", "long head"), ErrorCode::DuplicateName,
       "two curves called"},
      {"name of the fat", fullProjectWith("\"name\": \"spleen\"", "\"name\": \"fat\""),
       ErrorCode::DuplicateName, "two tissues are called"},
      {"fat that is none",
       fullProjectWith("{\"name\": \"fat\", \"kind\": \"fat\", \"color\": \"#f0e0a0\"},",
                       "{\"name\": \"fat\", \"kind\": \"obstacle\", \"file\": \"f\"},"),
       ErrorCode::DuplicateName, "belongs to the fat"},
      {"unknown bone",
       fullProjectWith("\"start\": {\"on\": \"bone\", \"name\": \"humerus\"}",
                       "\"start\": {\"on\": \"bone\", \"name\": \"ulna\"}"),
       ErrorCode::UnknownName,
       "forearm.ecorche:35:43: the start of \"biceps\", curve 1 (long head) is on bone \"ulna\""},
      {"unknown tissue",
       fullProjectWith("\"on\": \"tissue\", \"name\": \"belly\"",
                       "\"on\": \"tissue\", \"name\": \"bell\""),
       ErrorCode::UnknownName, "is on tissue \"bell\""},
      {"itself",
       fullProjectWith("\"on\": \"tissue\", \"name\": \"belly\"",
                       "\"on\": \"tissue\", \"name\": \"biceps\""),
       ErrorCode::UnknownName, "its own tissue"},
      {"no length", fullProjectWith("[0, 0, 9]", "[0, 0, 0]"), ErrorCode::ZeroLengthCurve,
       "forearm.ecorche:62:9: \"belly\" has no length"},
      {"one point", fullProjectWith(",\n            {\"at\": [0, 0, 9], \"tissue\": 1}", ""),
       ErrorCode::ZeroLengthCurve, "one control point"},
      {"point twice", fullProjectWith("[2.5, 3, 5]", "[1, 2, 3]"), ErrorCode::ZeroLengthCurve,
       "forearm.ecorche:32:13: control points 1 and 2"},
  };
  for (const BadCase& c : cases) {
    INFO(c.what);
    REQUIRE_FALSE((c.text.empty() && c.code != ErrorCode::FileEmpty));
    const Error error = refusalOf(c.text);
    INFO(error.text());
    CHECK(error.code == c.code);
    CHECK(error.text().find(c.message) != std::string::npos);
    CHECK(error.place.file == "forearm.ecorche");
  }
}

TEST_CASE("columns count characters, and a byte order mark is no character") {
  const Error error = refusalOf(
      "\xEF\xBB\xBF{\"schema\": 1, \"name\": \"Écorché\", \"nom\": 1, \"skin\": {\"file\": "
      "\"s\"}}");
  CHECK(error.code == ErrorCode::UnknownKey);
  CHECK(error.place.line == 1);
  CHECK(error.place.column == 34);
}

TEST_CASE("loading says what is wrong with the file itself") {
  test::TempFolder temp;
  CHECK(loadProject(temp.path() / "no.ecorche").error().code == ErrorCode::FileMissing);
  CHECK(loadProject(temp.path()).error().code == ErrorCode::FileNotReadable);
}

TEST_CASE("a project moved to another folder names the same meshes") {
  const Project here = parseProject(test::kFullProject, "work/arm/forearm.ecorche").value();
  const Project there = movedTo(here, "work/copies/arm");
  CHECK(there.skin.file == "../../arm/skin.obj");
  CHECK(there.tissues[1].attachments[1].patch->file == "../../arm/patches.obj");
  CHECK(meshPath(there, there.bones[1].mesh).lexically_normal() ==
        meshPath(here, here.bones[1].mesh).lexically_normal());
  CHECK(movedTo(there, "work/arm") == here);
  CHECK(pathFrom("", "meshes/skin.obj") == "meshes/skin.obj");
  CHECK(pathFrom("a/", "a/skin.obj") == "skin.obj");
}

TEST_CASE("what could not be loaded again is not written") {
  test::TempFolder temp;
  const auto file = temp.path() / "p.ecorche";
  Project project = parseProject(test::kFullProject, file).value();
  REQUIRE(saveProject(project, file));
  project.tissues[1].curves.clear();
  CHECK(saveProject(project, file).error().code == ErrorCode::MuscleWithoutCurve);
  CHECK(findFault(project, Completeness::Editing) == std::nullopt);
  CHECK(readFile(file).value() == test::kFullProject);
  CHECK(saveProject(loadProject(file).value(), temp.path() / "no" / "p.ecorche").error().code ==
        ErrorCode::FileNotWritable);
}

TEST_CASE("an older schema is brought up step by step, and its faults keep their place") {
  // Two made-up steps: "hide" became "skin", then "skin" became an object
  const std::vector<Migration> steps = {{1,
                                         [](Json& root) -> Result<void> {
                                           for (Json::Key& key : root.keys) {
                                             if (key.name == "hide") key.name = "skin";
                                           }
                                           return {};
                                         }},
                                        {2, [](Json& root) -> Result<void> {
                                           Json* const skin = root.find("skin");
                                           if (skin == nullptr)
                                             return fail(ErrorCode::MissingKey, "no skin", {});
                                           Json wrapped =
                                               Json::object().add("file", Json::string(skin->text));
                                           wrapped.spot = skin->spot;
                                           *skin = wrapped;
                                           return {};
                                         }}};
  Json root = parseJson("{\"schema\": 1,\n \"hide\": \"skin.obj\"}", "old").value();
  REQUIRE(migrate(root, 3, steps, "old"));
  CHECK(root.find("schema")->text == "3");
  CHECK(root.find("skin")->find("file")->text == "skin.obj");
  CHECK(spotOf(root, "/skin/file").line == 2);

  Json bare = parseJson("{\"schema\": 2}", "old").value();
  CHECK(migrate(bare, 3, steps, "old").error().place.file == "old");
  CHECK(migrate(bare, 1, steps, "old").error().code == ErrorCode::SchemaTooNew);
}

TEST_CASE("numbers are short and exact") {
  CHECK(numberText(0.1) == "0.1");
  CHECK(numberText(200000) == "200000");
  CHECK(numberText(-1.5e-7) == "-1.5e-7");
  CHECK(numberText(1e300) == "1e300");
  CHECK(lengthText(0.0015, Unit::Millimetre) == "1.5");
  CHECK(lengthText(-0.0254, Unit::Inch) == "-1");
  CHECK(lengthFrom("12.5", Unit::Centimetre) == 0.125);
  CHECK(lengthFrom("125e-1", Unit::Centimetre) == 0.125);
  CHECK(lengthFrom("1E+2", Unit::Millimetre) == 0.1);
  CHECK(angleTextDeg(*angleFromDeg("33.3")) == "33.3");
  CHECK(numberFrom("1e-999") == 0.0);
  CHECK(numberFrom("1e999") == std::nullopt);
  CHECK(numberFrom("12x") == std::nullopt);
  CHECK(numberFrom("nan") == std::nullopt);
}
