#include <ecorche/core/files.h>
#include <ecorche/exchange/json_parts.h>
#include <ecorche/exchange/model_record.h>
#include <fmt/format.h>

#include <algorithm>

namespace ecorche::exchange {

namespace {

ModelRecord recordFrom(const Json& j) {
  ModelRecord r;
  r.skinDiagonal = j.at("skin_diagonal_m");
  r.surfaceTolerance = j.at("surface_tolerance");
  for (const Json& t : j.at("tissues")) {
    TissueRecord tissue{countOf<std::int32_t>(t.at("id")),
                        t.at("name"),
                        t.at("kind"),
                        t.value("file", std::string()),
                        {}};
    for (const Json& c : t.at("curves")) {
      CurveRecord curve{c.at("name"), {}};
      for (const Json& p : c.at("points_m")) curve.points.push_back(pointOf(p));
      tissue.curves.push_back(std::move(curve));
    }
    r.tissues.push_back(std::move(tissue));
  }
  for (const Json& s : j.at("surfaces"))
    r.surfaces.push_back({s.at("name"), s.at("kind"), s.at("file")});
  for (const Json& p : j.at("cut_planes")) {
    r.planes.push_back({p.at("name"), pointOf(p.at("point_m")), pointOf(p.at("normal"))});
  }
  r.references = referencesOf(j.at("mesh_references"));
  return r;
}

}  // namespace

std::string printModelRecord(const ModelRecord& r) {
  Json j;
  j["schema"] = 1;
  j["skin_diagonal_m"] = r.skinDiagonal;
  j["surface_tolerance"] = r.surfaceTolerance;
  j["tissues"] = Json::array();
  for (const TissueRecord& t : r.tissues) {
    Json tissue{{"id", t.id}, {"name", t.name}, {"kind", t.kind}};
    if (!t.file.empty()) tissue["file"] = t.file;
    tissue["curves"] = Json::array();
    for (const CurveRecord& c : t.curves) {
      Json points = Json::array();
      for (const auto& p : c.points) points.push_back(pointJson(p));
      tissue["curves"].push_back({{"name", c.name}, {"points_m", std::move(points)}});
    }
    j["tissues"].push_back(std::move(tissue));
  }
  j["surfaces"] = Json::array();
  for (const SurfaceRecord& s : r.surfaces) {
    j["surfaces"].push_back({{"name", s.name}, {"kind", s.kind}, {"file", s.file}});
  }
  j["cut_planes"] = Json::array();
  for (const PlaneRecord& p : r.planes) {
    j["cut_planes"].push_back(
        {{"name", p.name}, {"point_m", pointJson(p.point)}, {"normal", pointJson(p.normal)}});
  }
  j["mesh_references"] = referencesJson(r.references);
  return j.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<ModelRecord> parseModelRecord(std::string_view text, const std::string& file) {
  try {
    return recordFrom(Json::parse(text));
  } catch (const Json::parse_error& e) {
    const auto at = static_cast<std::ptrdiff_t>(std::min(e.byte, text.size()));
    return fail(ErrorCode::FileSyntax, fmt::format("this is no JSON: {}", e.what()),
                {.file = file,
                 .line = static_cast<int>(1 + std::count(text.begin(), text.begin() + at, '\n'))});
  } catch (const Json::out_of_range& e) {
    return fail(ErrorCode::MissingKey, fmt::format("a key is missing; build again ({})", e.what()),
                {.file = file});
  } catch (const Json::exception& e) {
    return fail(ErrorCode::WrongType,
                fmt::format("the file is damaged; build again ({})", e.what()), {.file = file});
  }
}

Result<ModelRecord> readModelRecord(const std::filesystem::path& file) {
  const auto text = readFile(file);
  if (!text) return passOn(text);
  return parseModelRecord(*text, file.string());
}

}  // namespace ecorche::exchange
