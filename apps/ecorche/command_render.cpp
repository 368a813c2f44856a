#include <ecorche/engine/picture.h>
#include <ecorche/model/project_file.h>
#include <ecorche/render/image.h>
#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "cli.h"
#include "counts.h"

namespace ecorche::cli {

namespace {

struct RenderArguments {
  std::string source;
  std::string output;
  std::string size = "1600x1200";
  std::string clip;
  std::string tets;
  std::string up = "z";
  std::string palette = "anatomical";
  bool preview = false;
  engine::PictureSettings settings;
};

Result<void> parseSize(const std::string& text, engine::PictureSettings& settings) {
  int width = 0;
  int height = 0;
  int used = 0;
  const bool read = std::sscanf(text.c_str(), "%dx%d%n", &width, &height, &used) == 2 &&
                    used == static_cast<int>(text.size());
  if (!read || width < 16 || height < 16 || width > 16384 || height > 16384) {
    return fail(
        ErrorCode::ValueOutOfRange,
        fmt::format(
            "\"{}\" is no picture size; write WIDTHxHEIGHT in pixels, 16 to 16384, as in 1600x1200",
            text));
  }
  settings.width = width;
  settings.height = height;
  return {};
}

Result<void> runRender(RenderArguments args, Session& session) {
  if (auto ok = parseSize(args.size, args.settings); !ok) return passOn(ok);
  if (!args.clip.empty()) {
    auto plane = engine::parseClip(args.clip);
    if (!plane) return passOn(plane);
    args.settings.clip = *plane;
  }
  args.settings.up = static_cast<char>(std::toupper(args.up.front()));
  if (args.palette == "distinct") args.settings.palette = render::Palette::Distinct;

  Result<render::Image> picture;
  if (std::filesystem::is_directory(args.source)) {
    if (args.preview)
      return fail(ErrorCode::FileUnknownFormat,
                  "a built folder holds no fields to preview; render the project instead",
                  {.file = args.source});
    if (args.settings.fibers) {
      return fail(
          ErrorCode::FileUnknownFormat,
          "a built folder holds fibre directions, not traced fibres; render the project instead",
          {.file = args.source});
    }
    auto model = engine::readPictureModel(args.source, session.run);
    if (!model) return passOn(model);
    picture = engine::drawPicture(*model, args.settings, session.run);
  } else {
    auto project = model::loadProject(args.source);
    if (!project) return passOn(project);
    const auto tets = parseCountIfAny(args.tets);
    if (!tets) return passOn(tets);
    const engine::BuildOptions options{.tets = *tets};
    if (args.preview) {
      auto preview = engine::preparePreview(*project, options, session.run);
      if (!preview) return passOn(preview);
      picture =
          engine::drawPicture(engine::pictureModel(*project, *preview), args.settings, session.run);
    } else {
      auto build = engine::build(*project, options, session.run);
      if (!build) return passOn(build);
      picture = engine::drawPicture(*project, *build, args.settings, session.run);
    }
  }
  if (!picture) return passOn(picture);
  if (auto saved = render::writePng(args.output, *picture); !saved) return passOn(saved);
  if (session.globals.json) {
    fmt::print("{{\"picture\": \"{}\", \"width\": {}, \"height\": {}}}\n", args.output,
               picture->width, picture->height);
  } else if (!session.globals.quiet) {
    fmt::print("{}  {} × {} pixels\n", args.output, picture->width, picture->height);
  }
  return {};
}

}  // namespace

void addRender(CLI::App& app, Commands& commands) {
  auto args = std::make_shared<RenderArguments>();
  CLI::App* sub = app.add_subcommand(
      "render", "Draw a picture of a project or of a built folder, without any display");
  sub->add_option("SOURCE", args->source, "Project file or a folder that build wrote")->required();
  sub->add_option("-o,--output", args->output, "PNG to write")->required();
  sub->add_option("--view", args->settings.view,
                  "front, back, left, right, top, bottom, three-quarter, or az=30,el=20,zoom=1.5")
      ->capture_default_str();
  sub->add_option("--size", args->size, "WIDTHxHEIGHT in pixels")->capture_default_str();
  sub->add_option("--clip", args->clip,
                  "Cut: x=0.1, y<0.2 or z>0 [m]; the cut is coloured by tissue");
  sub->add_option("--hide", args->settings.hide,
                  "skin, bones, muscles, fillers, curves, fat (in cuts), or names; commas")
      ->delimiter(',');
  sub->add_option("--only", args->settings.only, "Show these muscles alone; commas")
      ->delimiter(',');
  sub->add_flag("--curves", args->settings.curves, "Draw the curves and their points on top");
  sub->add_flag("--fibers", args->settings.fibers,
                "Draw traced fibres in place of the muscles' surfaces; in previews streaks along "
                "the curves");
  sub->add_option("--palette", args->palette, "anatomical or distinct")
      ->check(CLI::IsMember({"anatomical", "distinct"}))
      ->capture_default_str();
  sub->add_option("--up", args->up, "Axis that points up: x, y or z")
      ->check(CLI::IsMember({"x", "y", "z", "X", "Y", "Z"}))
      ->capture_default_str();
  sub->add_option("--samples", args->settings.samples,
                  "Passes averaged: 4 quick, 16 good, 64 print")
      ->check(CLI::Range(1, 1024))
      ->capture_default_str();
  sub->add_option("--tets", args->tets, "For a project: about how many tets");
  sub->add_flag("--preview", args->preview,
                "For a project: draw tissues straight from their fields, without meshing");
  sub->add_flag("--motion", args->settings.motion,
                "As the window shows it while it is turned: one quick pass");
  sub->add_flag("--transparent", args->settings.transparentBackground, "No background");
  sub->footer(
      "Examples:\n"
      "  ecorche render out -o arm.png --view left --hide skin\n"
      "  ecorche render arm.ecorche -o slice.png --clip z=0.3 --palette distinct\n"
      "  ecorche render arm.ecorche -o fibres.png --hide skin --fibers\n"
      "  ecorche render arm.ecorche -o look.png --preview --motion");
  commands.push_back({sub, [args](Session& session) { return runRender(*args, session); }});
}

}  // namespace ecorche::cli
