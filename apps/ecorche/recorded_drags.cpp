#include "recorded_drags.h"

#include <ecorche/core/files.h>
#include <ecorche/model/project_file.h>
#include <fmt/format.h>

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

}  // namespace

Result<RecordedDrags> loadRecordedDrags(const std::string& project, const std::string& script,
                                        const std::string& tets) {
  auto loaded = model::loadProject(project);
  if (!loaded) return passOn(loaded);
  auto scripts = loadDrags(script);
  if (!scripts) return passOn(scripts);
  RecordedDrags out{std::move(*loaded), std::move(*scripts), {}};
  if (!tets.empty()) {
    const auto count = parseCount(tets);
    if (!count) return passOn(count);
    out.tets = *count;
  }
  return out;
}

}  // namespace ecorche::cli
