#include <ecorche/authoring/attachments.h>

#include <catch2/catch.hpp>

#include "support/paths.h"

using namespace ecorche;
using namespace ecorche::authoring;
using model::Attachment;

TEST_CASE("a plain table of attachments is read by its column names, in its unit") {
  const auto table = parseAttachments(
      "role,bone,muscle,x,y,z,patch\r\n"
      "origin,scapula,biceps brachii,10,20,30,a.obj\r\n"
      "\n"
      "insertion,\"radius, left\",biceps brachii,1e1,-2.5,0,\n"
      ",ulna,m. brachialis,1,2,3,\n",
      "t.csv", 0.001);
  REQUIRE(table);
  REQUIRE(table->size() == 2);
  const MuscleSites& biceps = (*table)[0];
  CHECK(biceps.muscle == "biceps_brachii");
  REQUIRE(biceps.sites.size() == 2);
  CHECK(biceps.sites[0].role == Attachment::Role::Origin);
  CHECK((biceps.sites[0].at - mesh::Vector3(0.01, 0.02, 0.03)).norm() < 1e-15);
  CHECK(biceps.sites[0].patchFile == "a.obj");
  CHECK(biceps.sites[1].bone == "radius, left");
  CHECK(biceps.sites[1].line == 4);
  CHECK((*table)[1].muscle == "brachialis");
  CHECK((*table)[1].sites[0].role == Attachment::Role::Unknown);
}

TEST_CASE("faults of a table are named with their line and column") {
  struct Case {
    const char* text;
    ErrorCode code;
    const char* message;
  };
  const std::vector<Case> cases = {
      {"", ErrorCode::FileEmpty, "t.csv: the table is empty"},
      {"muscle,bone,x,y\n", ErrorCode::MissingKey, "t.csv:1:1: the table has no column \"z\""},
      {"muscle,bone,x,y,z,colour\n", ErrorCode::UnknownKey,
       "t.csv:1:19: there is no column \"colour\""},
      {"muscle,bone,x,y,z\na,b,1,2\n", ErrorCode::FileSyntax,
       "t.csv:2:7: 4 cells where the first line has 5"},
      {"muscle,bone,x,y,z\na,b,1,two,3\n", ErrorCode::WrongType,
       "t.csv:2:7: \"two\" is not a number"},
      {"muscle,bone,x,y,z\na,b,1,nan,3\n", ErrorCode::WrongType,
       "t.csv:2:7: \"nan\" is not a number"},
      {"muscle,bone,x,y,z\n\n,b,1,2,3\n", ErrorCode::MissingKey,
       "t.csv:3:1: this line names no muscle"},
      {"muscle,bone,x,y,z,role\na,b,1,2,3,middle\n", ErrorCode::ValueOutOfRange,
       "t.csv:2:11: \"middle\" is no role"},
  };
  for (const Case& c : cases) {
    const auto table = parseAttachments(c.text, "t.csv", 1.0);
    INFO(c.text);
    REQUIRE_FALSE(table);
    CHECK(table.error().code == c.code);
    CHECK(table.error().text().substr(0, std::string_view(c.message).size()) == c.message);
  }
  CHECK(readAttachments("no/such.csv", 1.0).error().code == ErrorCode::FileMissing);
}

TEST_CASE("the dog's list of sites is read") {
  if (!test::haveData("dog/attachment_sites.csv")) return;
  const auto table = readAttachments(test::dataFolder() / "dog" / "attachment_sites.csv", 1.0);
  REQUIRE(table);
  std::size_t severalSites = 0;
  for (const MuscleSites& muscle : *table) severalSites += muscle.sites.size() >= 2 ? 1 : 0;
  CHECK(table->size() == 207);
  CHECK(severalSites == 200);  // as the data's own description counts them
}
