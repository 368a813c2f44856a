#include <ecorche/core/files.h>
#include <ecorche/model/command_text.h>
#include <ecorche/model/project_file.h>

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <nlohmann/json.hpp>

#include "cli.h"

namespace ecorche::cli {

namespace {

using namespace model;

struct RunOptions {
  std::string project;
  std::string script;
  std::string output;  // empty: the project itself
};

Result<std::string> scriptText(const std::string& script, const RunContext& run) {
  if (script != "-") return readFile(script);
  // Not std::cin, which sleeps on through Ctrl-C
  std::string text;
  std::array<char, 4096> buffer{};
  while (true) {
    const ssize_t got = read(STDIN_FILENO, buffer.data(), buffer.size());
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "interrupted; nothing was written");
    if (got == 0) return text;
    if (got > 0) text.append(buffer.data(), static_cast<std::size_t>(got));
    if (got < 0 && errno != EINTR) {
      return fail(ErrorCode::FileNotReadable, "standard input cannot be read");
    }
  }
}

Result<void> runScript(const RunOptions& options, Session& session) {
  auto project = loadProject(options.project);
  if (!project) return passOn(project);
  const auto text = scriptText(options.script, session.run);
  if (!text) return passOn(text);
  const std::string shown = options.script == "-" ? "standard input" : options.script;
  const auto script = parseScript(*text, shown);
  if (!script) return passOn(script);

  for (const ScriptLine& line : *script) {
    auto after = apply(*project, line.command);
    if (!after) {
      Error error = std::move(after.error());
      error.place.file = shown;
      error.place.line = line.line;
      return tl::unexpected<Error>(std::move(error));
    }
    project = std::move(*after);
  }

  const std::filesystem::path target = options.output.empty() ? options.project : options.output;
  if (!options.output.empty()) project = movedTo(std::move(*project), target.parent_path());
  if (session.run.cancelled())
    return fail(ErrorCode::Cancelled, "interrupted; nothing was written");
  if (auto saved = saveProject(*project, target); !saved) return saved;
  if (session.globals.json) {
    fmt::print(
        "{}\n",
        nlohmann::ordered_json{{"project", target.string()}, {"commands", script->size()}}.dump(2));
  } else if (!session.globals.quiet) {
    fmt::print("{}: {} command{} applied\n", target.string(), script->size(),
               script->size() == 1 ? "" : "s");
  }
  return {};
}

}  // namespace

void addRun(CLI::App& app, Commands& commands) {
  CLI::App* const sub =
      app.add_subcommand("run", "Apply a script of commands to a project and save it");
  const auto options = std::make_shared<RunOptions>();
  sub->add_option("PROJECT", options->project, "A project file (.ecorche)")->required();
  sub->add_option("SCRIPT", options->script,
                  "A text file with one command a line, or - for standard input")
      ->required();
  sub->add_option("-o,--output", options->output, "Save here and leave PROJECT alone");
  std::string footer =
      "All commands are applied or, where one is wrong, none; the message names its line.\n"
      "Lengths are in metres, curves and points count from 1, # starts a comment "
      "line.\n\nCommands:\n";
  for (const std::string& usage : commandUsages()) footer += "  " + usage + "\n";
  footer +=
      "\nExamples:\n  ecorche run arm.ecorche thicker.txt\n"
      "  echo 'point.value biceps 1 2 1.5' | ecorche run arm.ecorche - -o thick.ecorche";
  sub->footer(footer);
  commands.push_back({sub, [options](Session& session) { return runScript(*options, session); }});
}

}  // namespace ecorche::cli
