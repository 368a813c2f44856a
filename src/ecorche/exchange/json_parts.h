#pragma once

#include <ecorche/exchange/anatomy_file.h>

#include <Eigen/Core>
#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <utility>

namespace ecorche::exchange {

/// What several of our JSON files hold. Keys keep the order in which they are written; sources
/// only, headers stay free of nlohmann. Reading throws nlohmann's exceptions, which each reader
/// turns into an Error.
using Json = nlohmann::ordered_json;

/// A count or an index. nlohmann would convert any number, and what is beyond all integers without
/// defined result.
template <std::integral T = std::int64_t>
T countOf(const Json& j) {
  constexpr int kWrongType = 302;
  const bool whole =
      j.is_number_integer() &&
      !(j.is_number_unsigned() && !std::in_range<std::int64_t>(j.get<std::uint64_t>()));
  if (!whole || !std::in_range<T>(j.get<std::int64_t>()))
    throw Json::type_error::create(kWrongType, j.dump() + " is no count", &j);
  return static_cast<T>(j.get<std::int64_t>());
}

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
    const auto index = [&](const char* key) { return countOf<std::int32_t>(j.at(key)); };
    out.push_back({index("reference"), j.at("kind"), j.at("name"), j.value("other", std::string()),
                   index("index"), j.contains("other_index") ? index("other_index") : 0});
  }
  return out;
}

}  // namespace ecorche::exchange
