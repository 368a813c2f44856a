#include <ecorche/core/files.h>

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "cli.h"

namespace ecorche::cli {

namespace {

struct StudioOptions {
  std::vector<std::string> files;
};

// The window is a program of its own, so that the command line needs no Qt; it takes this one's
// place.
Result<void> startStudio(const StudioOptions& options) {
  const std::filesystem::path program = programFolder() / "ecorche-studio";
  if (!std::filesystem::exists(program)) {
    return fail(ErrorCode::FileMissing,
                "the window is not there; build it with ECORCHE_STUDIO=ON, or install it beside "
                "this program",
                {.file = program.string()});
  }
  std::vector<std::string> words{program.string()};
  words.insert(words.end(), options.files.begin(), options.files.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  return fail(ErrorCode::FileNotReadable,
              std::string("the window could not be started: ") + std::strerror(errno),
              {.file = program.string()});
}

}  // namespace

void addStudio(CLI::App& app, Commands& commands) {
  CLI::App* const sub = app.add_subcommand("studio", "Open the window to draw and edit muscles");
  const auto options = std::make_shared<StudioOptions>();
  sub->add_option("FILES", options->files, "A project (.ecorche), or meshes for a new one");
  sub->footer(
      "Examples:\n  ecorche studio\n  ecorche studio examples/arm/arm.ecorche\n"
      "  ecorche studio skin.obj bones/*.obj");
  commands.push_back({sub, [options](Session&) { return startStudio(*options); }});
}

}  // namespace ecorche::cli
