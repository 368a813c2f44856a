#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/program.h"

namespace ecorche::test {

/// A program run with --json that failed as it should: exit 1, one sentence for people, one code
/// for programs.
/// @param words  what the sentence must say, among other things
inline void requireRefused(const Outcome& run, const std::string& code,
                           const std::vector<std::string>& words) {
  INFO(run.err << run.out);
  CHECK(run.exitCode == 1);
  CHECK(run.err.starts_with("ecorche: "));
  CHECK(std::ranges::count(run.err, '\n') == 1);
  for (const std::string& word : words) {
    INFO("\"" << word << "\"");
    CHECK(run.err.find(word) != std::string::npos);
  }
  const auto json = nlohmann::json::parse(run.out, nullptr, false);
  REQUIRE(json.contains("error"));
  CHECK(json.at("error").at("code") == code);
}

}  // namespace ecorche::test
