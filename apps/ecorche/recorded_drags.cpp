#include "recorded_drags.h"

#include <ecorche/core/files.h>
#include <ecorche/model/project_file.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "counts.h"

namespace ecorche::cli {

namespace {

Result<std::vector<engine::DragScript>> loadDrags(const std::string& file) {
  const auto bytes = readFile(file);
  if (!bytes) return passOn(bytes);
  try {
    std::vector<engine::DragScript> out;
    const auto json = nlohmann::json::parse(*bytes);
    for (const auto& drag : json.at("drags")) {
      engine::DragScript script;
      script.name = drag.at("name").get<std::string>();
      script.muscle = drag.at("muscle").get<std::string>();
      script.curve = drag.at("curve").get<std::size_t>() - 1;
      script.point = drag.at("point").get<std::size_t>() - 1;
      script.frames = drag.at("frames").get<int>();
      for (const auto& p : drag.at("path_rel"))
        script.path.emplace_back(p.at(0).get<double>(), p.at(1).get<double>(),
                                 p.at(2).get<double>());
      out.push_back(std::move(script));
    }
    return out;
  } catch (const nlohmann::json::exception& e) {
    return fail(ErrorCode::FileSyntax,
                fmt::format("{}: not a list of drags ({}); bench/drags/left-39.json shows one",
                            file, e.what()),
                {.object = file});
  }
}

// Muscles all over the list, spreads all over what is asked for
void spreadOut(model::Project& project, int count) {
  std::vector<model::Tissue*> muscles;
  for (model::Tissue& tissue : project.tissues) {
    if (tissue.kind == model::Tissue::Kind::Muscle) muscles.push_back(&tissue);
  }
  const std::size_t wanted = std::min(static_cast<std::size_t>(count), muscles.size());
  for (std::size_t i = 0; i < wanted; ++i) {
    const auto between = [&](std::size_t k) {
      return std::pow(10.0, -1.0 + 2.0 * static_cast<double>(k % wanted) /
                                       static_cast<double>(std::max<std::size_t>(1, wanted - 1)));
    };
    model::Anisotropy& spread = muscles[i * (muscles.size() / wanted)]->anisotropy;
    spread.lambda2 = between(3 * i);
    spread.lambda3 = between(7 * i + 2);
  }
}

}  // namespace

Result<RecordedDrags> loadRecordedDrags(const std::string& project, const std::string& script,
                                        const std::string& tets, int anisotropic) {
  auto loaded = model::loadProject(project);
  if (!loaded) return passOn(loaded);
  auto scripts = loadDrags(script);
  if (!scripts) return passOn(scripts);
  spreadOut(*loaded, anisotropic);
  const auto count = parseCountIfAny(tets);
  if (!count) return passOn(count);
  return RecordedDrags{std::move(*loaded), std::move(*scripts), *count};
}

void addAnisotropic(CLI::App& bench, int& count) {
  bench
      .add_option("--anisotropic", count,
                  "Give so many of the muscles a spread of their own, from 0.1 to 10")
      ->check(CLI::Range(0, 10000));
}

}  // namespace ecorche::cli
