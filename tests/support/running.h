#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "support/paths.h"

namespace ecorche::test {

/// The command line while it runs, to send signals to. Killed at the end of the scope if nobody
/// waited for it.
class Running {
 public:
  /// @param folder       where it runs
  /// @param environment  "NAME=value", in place of or beside what this process has
  /// @param errors       gets its standard error; its standard output is dropped
  Running(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
          const std::vector<std::string>& environment, const std::filesystem::path& errors) {
    const std::string program = std::string(ECORCHE_BIN_DIR) + "/ecorche";
    std::vector<std::string> words{program};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<std::string> variables;
    for (char** v = environ; *v != nullptr; ++v) {
      const std::string variable = *v;
      bool replaced = false;
      for (const std::string& own : environment)
        replaced = replaced || variable.starts_with(own.substr(0, own.find('=') + 1));
      if (!replaced) variables.push_back(variable);
    }
    variables.insert(variables.end(), environment.begin(), environment.end());
    const auto pointers = [](std::vector<std::string>& list) {
      std::vector<char*> out;
      for (std::string& s : list) out.push_back(s.data());
      out.push_back(nullptr);
      return out;
    };

    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addchdir_np(&files, folder.c_str());
    posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_addopen(&files, 2, errors.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    REQUIRE(posix_spawn(&pid_, program.c_str(), &files, nullptr, pointers(words).data(),
                        pointers(variables).data()) == 0);
    posix_spawn_file_actions_destroy(&files);
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  ~Running() {
    if (!over_) send(SIGKILL), wait();
  }

  void send(int signal) const { kill(pid_, signal); }

  /// @return its exit code, or minus the signal that ended it
  int wait() {
    int status = 0;
    while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
    }
    over_ = true;
    return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
  }

  /// True while it has not ended.
  [[nodiscard]] bool runs() const {
    siginfo_t ended{};
    return waitid(P_PID, id_t(pid_), &ended, WEXITED | WNOWAIT | WNOHANG) == 0 && ended.si_pid == 0;
  }

 private:
  pid_t pid_ = 0;
  bool over_ = false;
};

/// How many processes have this text among the words they were started with.
inline int processesWith(const std::string& text) {
  int count = 0;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/proc", ignored)) {
    std::ifstream file(entry.path() / "cmdline");
    const std::string words{std::istreambuf_iterator<char>(file), {}};
    count += words.find(text) != std::string::npos;
  }
  return count;
}

}  // namespace ecorche::test
