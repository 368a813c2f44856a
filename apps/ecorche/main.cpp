#include <ecorche/core/parallel.h>

#include <fmt/format.h>

#include <unistd.h>
#include <csignal>
#include <nlohmann/json.hpp>

#include "cli.h"
#include "progress.h"

namespace ecorche::cli {
namespace {

std::atomic<RunContext*> running{nullptr};

// First signal: stop tidily, nothing half-written stays. Second: at once.
void interrupt(int) {
  static std::atomic<bool> before{false};
  if (before.exchange(true)) _exit(kInterrupted);
  if (RunContext* run = running.load()) run->cancel();
}

int exitCode(ErrorCode code) {
  if (code == ErrorCode::Cancelled) return kInterrupted;
  return code == ErrorCode::Internal ? kOurFault : kInputFault;
}

int report(const Error& error, const Globals& globals) {
  if (error.code == ErrorCode::Cancelled) {
    fmt::print(stderr, "ecorche: interrupted; nothing was written\n");
  } else {
    fmt::print(stderr, "ecorche: {}\n", error.text());
  }
  if (globals.json) {
    nlohmann::ordered_json json = {{"code", name(error.code)}, {"message", error.message}};
    if (!error.place.file.empty()) json["file"] = error.place.file;
    if (error.place.line > 0) json["line"] = error.place.line;
    if (error.place.column > 0) json["column"] = error.place.column;
    if (!error.place.object.empty()) json["object"] = error.place.object;
    if (const auto& p = error.place.point) json["point"] = {p->x(), p->y(), p->z()};
    const auto whole = nlohmann::ordered_json{{"error", std::move(json)}};
    fmt::print("{}\n", whole.dump(2, ' ', false, nlohmann::json::error_handler_t::replace));
  }
  return exitCode(error.code);
}

int runCommand(const Command& command, const Globals& globals) {
  const ThreadLimit limit(globals.threads);
  ProgressPrinter printer(globals.quiet);
  RunContext run([&](std::string_view stage, double fraction) { printer.show(stage, fraction); });
  running = &run;
  struct sigaction action = {};
  action.sa_handler = interrupt;  // without SA_RESTART: whoever waits for input wakes up
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  std::signal(SIGXFSZ,
              SIG_IGN);  // a file that may not grow is an error to report, like a full disk

  Session session{globals, run};
  const Result<void> done = command.body(session);
  running = nullptr;
  printer.finish();
  Globals how = globals;
  how.json = globals.json && !session.answered;
  return done ? kDone : report(done.error(), how);
}

int run(int argc, char** argv) {
  CLI::App app("Écorché: volumetric muscles of any creature, from skin, bones and curves.");
  app.name("ecorche");
  app.set_version_flag("--version", "ecorche " ECORCHE_VERSION);
  app.require_subcommand(1);
  app.fallthrough();
  app.footer(
      "Exit codes: 0 done, 1 the input is at fault, 2 wrong usage, 70 our fault, 130 interrupted.\n"
      "\"ecorche COMMAND --help\" shows the options of a command and examples.");

  Globals globals;
  app.add_flag("--quiet,-q", globals.quiet, "No progress and no notes, errors only");
  app.add_flag("--json", globals.json, "One JSON object on standard output instead of tables");
  app.add_option("--threads", globals.threads, "How many threads to use (default: all cores)")
      ->check(CLI::Range(1, 1024));

  Commands commands;
  addNew(app, commands);
  addBuild(app, commands);
  addCheck(app, commands);
  addInfo(app, commands);
  addRender(app, commands);
  addRun(app, commands);
  addBench(app, commands);
  addStudio(app, commands);

  try {
    app.parse(argc, argv);
  } catch (const CLI::RequiredError& e) {
    // CLI11 says only that a command is missing, also where one is misspelt
    const std::vector<std::string> unknown = app.remaining();
    if (!app.get_subcommands().empty() || unknown.empty()) return app.exit(e) == 0 ? kDone : kUsage;
    fmt::print(stderr, "ecorche: there is no command \"{}\"; ecorche --help lists them\n",
               unknown.front());
    return kUsage;
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kDone : kUsage;
  }
  for (const Command& command : commands) {
    if (command.app->parsed()) return runCommand(command, globals);
  }
  return kUsage;
}

}  // namespace
}  // namespace ecorche::cli

int main(int argc, char** argv) {
  using namespace ecorche;
  try {
    return cli::run(argc, argv);
  } catch (const std::bad_alloc&) {
    return cli::report({ErrorCode::OutOfMemory, "there is not enough memory; try fewer tets", {}},
                       {});
  } catch (const std::exception& e) {
    const std::string what = fmt::format("this is our fault, please report it: {}", e.what());
    return cli::report({ErrorCode::Internal, what, {}}, {});
  }
}
