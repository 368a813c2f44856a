#include <ecorche/core/files.h>
#include <ecorche/model/project_file.h>

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "model/sample_project.h"
#include "support/paths.h"

using namespace ecorche;
using namespace ecorche::model;
namespace fs = std::filesystem;

namespace {

const fs::path kSchemaFile = fs::path(ECORCHE_SOURCE_DIR) / "docs" / "project.schema.json";

int exitCode(const std::string& command) { return WEXITSTATUS(std::system(command.c_str())); }

bool haveValidator() {
  if (exitCode("/usr/bin/python3 -c 'import jsonschema' 2>/dev/null") == 0) return true;
  WARN(
      "SKIPPED: /usr/bin/python3 has no jsonschema (python3-jsonschema); the schema was not tried "
      "on examples");
  return false;
}

/// One run for all files: starting python takes longer than validating.
std::set<std::string> refusedBySchema(const std::vector<fs::path>& files, const fs::path& temp) {
  REQUIRE(writeFileWhole(temp / "validate.py", R"(
import json, sys, jsonschema
schema = json.load(open(sys.argv[1]))
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)
with open(sys.argv[2], "w") as out:
    for file in sys.argv[3:]:
        if not validator.is_valid(json.load(open(file))):
            print(file, file=out)
)"));
  std::string command =
      fmt::format("/usr/bin/python3 '{}' '{}' '{}'", (temp / "validate.py").string(),
                  kSchemaFile.string(), (temp / "refused").string());
  for (const fs::path& file : files) command += fmt::format(" '{}'", file.string());
  REQUIRE(exitCode(command) == 0);
  std::set<std::string> refused;
  const auto text = readFile(temp / "refused");
  std::istringstream lines(text ? *text : "");
  for (std::string line; std::getline(lines, line);) refused.insert(line);
  return refused;
}

}  // namespace

TEST_CASE("schema and loader know the same keys") {
  const auto schema = nlohmann::json::parse(readFile(kSchemaFile).value());
  const auto& definitions = schema["$defs"];
  std::set<std::string> seen;
  for (const ObjectKeys& keys : projectKeys()) {
    const std::string object(keys.object);
    INFO(object);
    seen.insert(object);
    REQUIRE(definitions.contains(object));
    const auto& definition = definitions[object];
    CHECK(definition["additionalProperties"] == false);

    std::set<std::string> inLoader(keys.required.begin(), keys.required.end());
    std::set<std::string> required = inLoader;
    inLoader.insert(keys.optional.begin(), keys.optional.end());
    std::set<std::string> inSchema;
    for (const auto& [key, value] : definition["properties"].items()) inSchema.insert(key);
    CHECK(inSchema == inLoader);

    // A muscle without curves has a code of its own in the loader
    if (object == "curve_tissue") required.insert("curves");
    const auto inSchemaRequired =
        definition.value("required", nlohmann::json::array()).get<std::set<std::string>>();
    CHECK(inSchemaRequired == required);
  }
  for (const auto& [name, definition] : definitions.items()) {
    INFO(name);
    if (definition.contains("additionalProperties")) CHECK(seen.count(name) == 1);
  }
}

TEST_CASE("the schema accepts what the loader accepts and refuses what breaks its form") {
  if (!haveValidator()) return;
  test::TempFolder temp;
  std::vector<fs::path> files;
  const auto keep = [&](const std::string& text) {
    files.push_back(temp.path() / fmt::format("{}.ecorche", files.size()));
    REQUIRE(writeFileWhole(files.back(), text));
  };
  using test::fullProjectWith;
  keep(std::string(test::kFullProject));
  keep(R"({"schema": 1, "skin": {"file": "skin.obj"}})");
  keep(fullProjectWith("\"layer\"", "\"lair\""));
  keep(fullProjectWith("\"name\": \"humerus\", ", ""));
  keep(fullProjectWith("[2.5, 3, 5]", "[2.5, 3]"));
  keep(fullProjectWith("200000", "7"));
  keep(fullProjectWith("\"fat\": 0.25", "\"edge_length\": 1"));
  keep(fullProjectWith("\"file\": \"spleen.obj\"", "\"curves\": []"));
  keep(fullProjectWith("#c0504d", "red"));
  keep(fullProjectWith("\"cm\"", "\"furlong\""));
  keep(fullProjectWith("1.25", "0"));
  keep(fullProjectWith("\"layer\": 1", "\"layer\": -1"));
  keep(fullProjectWith("\"schema\": 1", "\"schema\": 2"));
  const auto refused = refusedBySchema(files, temp.path());
  for (const fs::path& file : files) {
    INFO(readFile(file).value());
    CHECK(refused.contains(file.string()) == !loadProject(file));
  }
}

TEST_CASE("every project that ships keeps the schema and loads") {
  const fs::path examples = fs::path(ECORCHE_SOURCE_DIR) / "examples";
  if (!fs::exists(examples)) return;
  std::vector<fs::path> shipped;
  for (const auto& entry : fs::recursive_directory_iterator(examples)) {
    if (entry.path().extension() == ".ecorche") shipped.push_back(entry.path());
  }
  for (const fs::path& file : shipped) {
    const auto project = loadProject(file);
    INFO((project ? std::string() : project.error().text()));
    CHECK(project);
  }
  if (shipped.empty() || !haveValidator()) return;
  test::TempFolder temp;
  CHECK(refusedBySchema(shipped, temp.path()).empty());
}
