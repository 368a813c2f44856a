#pragma once

#include <ecorche/exchange/anatomy_file.h>

#include <Eigen/Core>
#include <nlohmann/json.hpp>

namespace ecorche::exchange {

/// What several of our JSON files hold. Keys keep the order in which they are written; sources
/// only, headers stay free of nlohmann. Reading throws nlohmann's exceptions, which each reader
/// turns into an Error.
using Json = nlohmann::ordered_json;

inline Json pointJson(const Eigen::Vector3d& p) { return Json::array({p.x(), p.y(), p.z()}); }

inline Eigen::Vector3d pointOf(const Json& j) {
  return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()};
}

inline Json referencesJson(const std::vector<FaceReference>& references) {
  Json list = Json::array();
  for (const FaceReference& r : references) {
    Json j{{"reference", r.reference}, {"kind", r.kind}, {"name", r.name}, {"index", r.index}};
    if (r.kind == "interface") {
      j["other"] = r.other;
      j["other_index"] = r.otherIndex;
    }
    list.push_back(std::move(j));
  }
  return list;
}

inline std::vector<FaceReference> referencesOf(const Json& list) {
  std::vector<FaceReference> out;
  for (const Json& j : list) {
    out.push_back({j.at("reference"), j.at("kind"), j.at("name"), j.value("other", std::string()),
                   j.at("index"), j.value("other_index", 0)});
  }
  return out;
}

}  // namespace ecorche::exchange
