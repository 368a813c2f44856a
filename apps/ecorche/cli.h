#pragma once

#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <vector>

namespace ecorche::cli {

/// What the program answers to the shell.
enum ExitCode {
  kDone = 0,        ///< repairs are in the report
  kInputFault = 1,  ///< one message: what, where, way out
  kUsage = 2,
  kOurFault = 70,
  kInterrupted = 130
};

/// Flags that every command knows, before or behind its name.
struct Globals {
  bool quiet = false;  ///< nothing on standard error but the error
  bool json = false;   ///< standard output holds one JSON object and nothing else
  int threads = 0;     ///< 0: all cores
};

/// What a command runs with.
struct Session {
  const Globals& globals;
  RunContext& run;  ///< cancelled by Ctrl-C; its progress goes to standard error
  bool answered =
      false;  ///< standard output holds its JSON object already, whatever becomes of the command
};

/// Tables and JSON go to standard output; an Error is printed by main and becomes the exit code.
using Body = std::function<Result<void>(Session&)>;

struct Command {
  CLI::App* app;
  Body body;
};

/// Each command has a file command_<name>.cpp with one function that adds its subcommand, options
/// and body.
using Commands = std::vector<Command>;
void addNew(CLI::App& app, Commands& commands);
void addBench(CLI::App& app, Commands& commands);
void addBuild(CLI::App& app, Commands& commands);
void addCheck(CLI::App& app, Commands& commands);
void addInfo(CLI::App& app, Commands& commands);
void addRender(CLI::App& app, Commands& commands);
void addRun(CLI::App& app, Commands& commands);
void addStudio(CLI::App& app, Commands& commands);

}  // namespace ecorche::cli
