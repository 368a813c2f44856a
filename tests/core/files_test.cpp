#include <ecorche/core/files.h>

#include <fmt/format.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <fstream>
#include <mutex>
#include <thread>
#include <vector>

#include "support/paths.h"

using namespace ecorche;
namespace fs = std::filesystem;

TEST_CASE("a staged folder appears whole or not at all") {
  test::TempFolder temp;
  const fs::path target = temp.path() / "out";
  {
    auto staged = StagedFolder::create(target);
    REQUIRE(staged);
    std::ofstream(staged->path() / "a.txt") << "new";
    CHECK_FALSE(fs::exists(target));
  }
  CHECK_FALSE(fs::exists(target));
  CHECK(fs::is_empty(temp.path()));

  for (const char* text : {"first", "second"}) {
    auto staged = StagedFolder::create(target, {"a.txt", {"a.txt"}});
    REQUIRE(staged);
    std::ofstream(staged->path() / "a.txt") << text;
    REQUIRE(staged->commit());
    CHECK(readFile(target / "a.txt").value() == text);
  }
  CHECK(std::distance(fs::directory_iterator(temp.path()), {}) == 1);
}

TEST_CASE("a staged folder never replaces what somebody else left there") {
  test::TempFolder temp;
  const fs::path target = temp.path() / "out";
  fs::create_directory(target);
  CHECK(StagedFolder::create(target));  // empty

  const Replaceable ours{"mark", {"mark", "parts"}};
  fs::create_directory(target / "parts");
  const auto unmarked = StagedFolder::create(target, ours);
  REQUIRE_FALSE(unmarked);
  CHECK(unmarked.error().code == ErrorCode::FileNotWritable);
  std::ofstream(target / "mark") << "x";
  CHECK(StagedFolder::create(target, ours));
  std::ofstream(target / "diary.txt") << "x";
  const auto foreign = StagedFolder::create(target, ours);
  REQUIRE_FALSE(foreign);
  CHECK(foreign.error().message.find("\"diary.txt\"") != std::string::npos);
  CHECK(fs::exists(target / "diary.txt"));
  CHECK(std::distance(fs::directory_iterator(temp.path()), {}) == 1);
}

TEST_CASE("what somebody puts there while a folder is staged is not lost either") {
  test::TempFolder temp;
  const fs::path target = temp.path() / "out";
  auto staged = StagedFolder::create(target, {"mark", {"mark"}});
  REQUIRE(staged);
  fs::create_directory(target);
  std::ofstream(target / "diary.txt") << "x";
  const auto done = staged->commit();
  REQUIRE_FALSE(done);
  CHECK(done.error().code == ErrorCode::FileNotWritable);
  CHECK(done.error().message.find("\"diary.txt\"") != std::string::npos);
  CHECK(fs::exists(target / "diary.txt"));
}

TEST_CASE("many may write one folder or file at once: all succeed, and one of them stands there") {
  test::TempFolder temp;
  const fs::path target = temp.path() / "deep" / "out";
  constexpr int kWriters = 4, kTimes = 60;
  std::atomic<int> refused{0};
  std::mutex mutex;
  std::string why;
  const auto note = [&](const Error& error) {
    const std::lock_guard lock(mutex);
    ++refused;
    why += error.text() + "\n";
  };
  {
    std::vector<std::jthread> writers;
    for (int w = 0; w < kWriters; ++w) {
      writers.emplace_back([&, w] {
        for (int k = 0; k < kTimes; ++k) {
          const auto text = fmt::format("{} {}", w, k);
          auto staged = StagedFolder::create(target, {"a", {"a", "b"}});
          if (staged) {
            for (const char* file : {"a", "b"}) std::ofstream(staged->path() / file) << text;
          }
          // Some give up, and take with them what nobody else uses
          if (!staged) note(staged.error());
          if (staged && k % 5 != 4) {
            if (const auto done = staged->commit(); !done) note(done.error());
          }
          if (const auto done = writeFileWhole(temp.path() / "file", text); !done)
            note(done.error());
        }
      });
    }
  }
  INFO(why);
  CHECK(refused == 0);
  CHECK(readFile(target / "a").value() == readFile(target / "b").value());
  CHECK(readFile(temp.path() / "file"));
  CHECK(std::distance(fs::directory_iterator(temp.path()), {}) == 2);
  CHECK(std::distance(fs::directory_iterator(target.parent_path()), {}) == 1);
}

TEST_CASE("parents made for a staged folder go with it") {
  test::TempFolder temp;
  const fs::path target = temp.path() / "a" / "b" / "out";
  { CHECK(StagedFolder::create(target)); }
  CHECK(fs::is_empty(temp.path()));
  {
    auto staged = StagedFolder::create(target);
    REQUIRE(staged);
    REQUIRE(staged->commit());
  }
  CHECK(fs::is_directory(target));
}

TEST_CASE("leftovers of a killed process go with the next output of the same name") {
  test::TempFolder temp;
  // In a container the next process often has the same number
  const fs::path leftover = temp.path() / fmt::format(".out.ecorche-{}-0", getpid());
  fs::create_directory(leftover);
  std::ofstream(leftover / "half") << "x";
  const fs::path foreign = temp.path() / ".out2.ecorche-999999999-0";
  fs::create_directory(foreign);
  auto staged = StagedFolder::create(temp.path() / "out");
  REQUIRE(staged);
  CHECK_FALSE(fs::exists(leftover / "half"));  // its name may be in use again
  CHECK(fs::exists(foreign));
  const auto beside = StagedFolder::create(temp.path() / "out");
  REQUIRE(beside);
  CHECK(fs::exists(staged->path()));

  std::ofstream(temp.path() / ".file.ecorche-7-0") << "half";
  REQUIRE(writeFileWhole(temp.path() / "file", "whole"));
  CHECK_FALSE(fs::exists(temp.path() / ".file.ecorche-7-0"));
}

TEST_CASE("files say what is wrong with them") {
  test::TempFolder temp;
  CHECK(readFile(temp.path() / "no").error().code == ErrorCode::FileMissing);
  CHECK(readFile(temp.path()).error().code == ErrorCode::FileNotReadable);
  std::ofstream(temp.path() / "empty").flush();
  CHECK(readFile(temp.path() / "empty").error().code == ErrorCode::FileEmpty);
  CHECK(writeFileWhole(temp.path() / "no" / "file", "x").error().code ==
        ErrorCode::FileNotWritable);
  CHECK(StagedFolder::create(temp.path() / "empty").error().code == ErrorCode::FileNotWritable);
  REQUIRE(writeFileWhole(temp.path() / "file", "x"));
  CHECK(readFile(temp.path() / "file").value() == "x");
}

TEST_CASE("hashes tell texts apart that join to the same bytes") {
  Hasher a;
  a.text("ab");
  a.text("c");
  Hasher b;
  b.text("a");
  b.text("bc");
  CHECK(a.hex() != b.hex());
  CHECK(a.hex().size() == 32);
}
