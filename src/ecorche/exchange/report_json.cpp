#include <ecorche/core/files.h>
#include <ecorche/exchange/json_parts.h>
#include <ecorche/exchange/report.h>
#include <fmt/format.h>

#include <algorithm>

namespace ecorche::exchange {

namespace {

Json checkJson(const Check& c) {
  Json j{{"name", c.name},
         {"pass", c.pass},
         {"value", c.value},
         {"limit", c.limit},
         {"detail", c.detail}};
  if (!c.object.empty()) j["object"] = c.object;
  if (c.point) j["point_m"] = pointJson(*c.point);
  return j;
}

Json tissueJson(const TissueFigures& t) {
  Json j{{"id", t.id}, {"name", t.name}, {"kind", t.kind}};
  if (!t.side.empty()) j["side"] = t.side;
  if (!t.group.empty()) j["group"] = t.group;
  if (!t.file.empty()) j["file"] = t.file;
  j["volume_cm3"] = t.volumeCm3;
  j["area_cm2"] = t.areaCm2;
  j["components"] = t.components;
  j["tets"] = t.tets;
  j["attachments"] = Json::array();
  for (const AttachmentFigures& a : t.attachments) {
    Json entry;
    if (!a.role.empty()) entry["role"] = a.role;
    entry["on"] = a.on;
    entry["name"] = a.name;
    entry["area_cm2"] = a.areaCm2;
    entry["centroid_m"] = pointJson(a.centroid);
    j["attachments"].push_back(std::move(entry));
  }
  if (t.fibers) {
    j["fibers"] = {{"length_cm", t.fibers->lengthCm},
                   {"length_sd_cm", t.fibers->lengthSdCm},
                   {"traced", t.fibers->traced},
                   {"angle_to_curve_deg", t.fibers->angleToCurveDeg},
                   {"interior_extrema_share", t.fibers->interiorExtremaShare},
                   {"spread_share", t.fibers->spreadShare}};
  }
  return j;
}

Json findingJson(const Finding& f) {
  Json j{{"severity", name(f.severity)},
         {"kind", f.kind},
         {"object", f.object},
         {"message", f.message}};
  if (f.point) j["point_m"] = pointJson(*f.point);
  j["size"] = f.size;
  return j;
}

std::vector<std::int64_t> countsOf(const Json& j) {
  std::vector<std::int64_t> out;
  for (const Json& count : j) out.push_back(countOf(count));
  return out;
}

std::optional<Eigen::Vector3d> optionalPoint(const Json& j) {
  if (!j.contains("point_m")) return std::nullopt;
  return pointOf(j.at("point_m"));
}
std::string optionalText(const Json& j, const char* key) { return j.value(key, std::string()); }

Check checkFrom(const Json& j) {
  // A value that is not finite is written as null
  const auto number = [&](const char* key) {
    return j.at(key).is_null() ? std::numeric_limits<double>::quiet_NaN() : j.at(key).get<double>();
  };
  return {j.at("name"),    j.at("pass"),   number("value"),
          number("limit"), j.at("detail"), optionalText(j, "object"),
          optionalPoint(j)};
}

TissueFigures tissueFrom(const Json& j) {
  TissueFigures t;
  t.id = countOf<std::int32_t>(j.at("id"));
  t.name = j.at("name");
  t.kind = j.at("kind");
  t.side = optionalText(j, "side");
  t.group = optionalText(j, "group");
  t.file = optionalText(j, "file");
  t.volumeCm3 = j.at("volume_cm3");
  t.areaCm2 = j.at("area_cm2");
  t.components = countOf(j.at("components"));
  t.tets = countOf(j.at("tets"));
  for (const Json& a : j.at("attachments")) {
    t.attachments.push_back({optionalText(a, "role"), a.at("on"), a.at("name"), a.at("area_cm2"),
                             pointOf(a.at("centroid_m"))});
  }
  if (j.contains("fibers")) {
    const Json& f = j.at("fibers");
    t.fibers = FiberFigures{
        f.at("length_cm"),          f.at("length_sd_cm"),           countOf(f.at("traced")),
        f.at("angle_to_curve_deg"), f.at("interior_extrema_share"), f.at("spread_share")};
  }
  return t;
}

Json envelopeJson(const EnvelopeFigures& e) {
  return {{"new_vertices", e.newVertices},
          {"clamped_vertices", e.clampedVertices},
          {"repaired_vertices", e.repairedVertices},
          {"rebuilt_tets", e.rebuiltTets},
          {"non_positive_at_32_bits", e.nonPositiveAt32Bits},
          {"off_label_tets", e.offLabelTets},
          {"off_label_share", e.offLabelShare},
          {"off_label_unexplained", e.offLabelUnexplained},
          {"islands", e.islands},
          {"island_share", e.islandShare},
          {"fat_pockets", e.fatPockets}};
}

EnvelopeFigures envelopeFrom(const Json& j) {
  return {countOf(j.at("new_vertices")),
          countOf(j.at("clamped_vertices")),
          countOf(j.at("repaired_vertices")),
          countOf(j.at("rebuilt_tets")),
          countOf(j.at("non_positive_at_32_bits")),
          countOf(j.at("off_label_tets")),
          j.at("off_label_share"),
          countOf(j.at("off_label_unexplained")),
          countOf(j.at("islands")),
          j.at("island_share"),
          countOf(j.at("fat_pockets"))};
}

Finding findingFrom(const Json& j) {
  Finding f;
  for (const Severity s :
       {Severity::Note, Severity::Repaired, Severity::Warning, Severity::Error}) {
    if (j.at("severity") == name(s)) f.severity = s;
  }
  f.kind = j.at("kind");
  f.object = j.at("object");
  f.message = j.at("message");
  f.point = optionalPoint(j);
  f.size = j.at("size");
  return f;
}

Json reportJson(const Report& r) {
  Json j;
  j["schema"] = 1;
  j["program"] = r.program;
  j["project"] = r.project;
  j["source_unit"] = r.sourceUnit;
  j["skin_diagonal_m"] = r.skinDiagonal;
  j["domain"] = {{"volume_cm3", r.domainVolumeCm3},
                 {"tets", r.domainTets},
                 {"vertices", r.domainVertices},
                 {"free_vertices", r.freeVertices}};
  j["anatomy"] = {{"tets", r.tets}, {"vertices", r.vertices}};
  j["tissues"] = Json::array();
  for (const TissueFigures& t : r.tissues) j["tissues"].push_back(tissueJson(t));
  j["tissues_per_tet"] = r.tissuesPerTet;
  j["envelope"] = envelopeJson(r.envelope);
  j["quality"] = {{"min_dihedral_deg", r.quality.minDihedralDeg},
                  {"max_dihedral_deg", r.quality.maxDihedralDeg},
                  {"min_dihedral_histogram", r.quality.minDihedralHistogram},
                  {"smallest_volume_m3", r.quality.smallestVolume}};
  j["checks"] = Json::array();
  for (const Check& c : r.checks) j["checks"].push_back(checkJson(c));
  j["mesh_references"] = referencesJson(r.references);
  j["findings"] = Json::array();
  for (const Finding& f : r.findings) j["findings"].push_back(findingJson(f));
  j["stages"] = Json::array();
  for (const auto& s : r.stages)
    j["stages"].push_back({{"stage", s.stage}, {"seconds", s.seconds}, {"level", s.level}});
  j["total_seconds"] = r.totalSeconds;
  j["peak_memory_bytes"] = r.peakMemoryBytes;
  j["peak_worker_memory_bytes"] = r.peakWorkerMemoryBytes;
  j["machine"] = {{"processor", r.machine.processor},
                  {"cores", r.machine.cores},
                  {"threads", r.machine.threads},
                  {"blas", r.machine.blas}};
  return j;
}

Report reportFrom(const Json& j) {
  Report r;
  r.program = j.at("program");
  r.project = j.at("project");
  r.sourceUnit = j.at("source_unit");
  r.skinDiagonal = j.at("skin_diagonal_m");
  const Json& domain = j.at("domain");
  r.domainVolumeCm3 = domain.at("volume_cm3");
  r.domainTets = countOf(domain.at("tets"));
  r.domainVertices = countOf(domain.at("vertices"));
  r.freeVertices = countOf(domain.at("free_vertices"));
  r.tets = countOf(j.at("anatomy").at("tets"));
  r.vertices = countOf(j.at("anatomy").at("vertices"));
  for (const Json& t : j.at("tissues")) r.tissues.push_back(tissueFrom(t));
  r.tissuesPerTet = j.at("tissues_per_tet").get<std::vector<double>>();
  r.envelope = envelopeFrom(j.at("envelope"));
  const Json& quality = j.at("quality");
  r.quality.minDihedralDeg = quality.at("min_dihedral_deg");
  r.quality.maxDihedralDeg = quality.at("max_dihedral_deg");
  r.quality.minDihedralHistogram = countsOf(quality.at("min_dihedral_histogram"));
  r.quality.smallestVolume = quality.at("smallest_volume_m3");
  for (const Json& c : j.at("checks")) r.checks.push_back(checkFrom(c));
  r.references = referencesOf(j.at("mesh_references"));
  for (const Json& f : j.at("findings")) r.findings.push_back(findingFrom(f));
  for (const Json& s : j.at("stages"))
    r.stages.push_back({s.at("stage"), s.at("seconds"), countOf<int>(s.at("level"))});
  r.totalSeconds = j.at("total_seconds");
  r.peakMemoryBytes = countOf(j.at("peak_memory_bytes"));
  r.peakWorkerMemoryBytes = countOf(j.at("peak_worker_memory_bytes"));
  const Json& machine = j.at("machine");
  r.machine = {machine.at("processor"), countOf(machine.at("cores")),
               countOf(machine.at("threads")), machine.at("blas")};
  return r;
}

}  // namespace

std::string printReport(const Report& report) {
  // Names come from files of any encoding: what is no UTF-8 is replaced, not thrown over
  return reportJson(report).dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<Report> parseReport(const std::string& text, const std::string& file) {
  try {
    return reportFrom(Json::parse(text));
  } catch (const Json::parse_error& e) {
    const auto line =
        1 + std::count(text.begin(),
                       text.begin() + static_cast<std::ptrdiff_t>(std::min(e.byte, text.size())),
                       '\n');
    return fail(ErrorCode::FileSyntax, fmt::format("the report is no JSON: {}", e.what()),
                {.file = file, .line = static_cast<int>(line)});
  } catch (const Json::out_of_range& e) {
    return fail(ErrorCode::MissingKey,
                fmt::format("the report lacks a key; build again ({})", e.what()), {.file = file});
  } catch (const Json::exception& e) {
    return fail(ErrorCode::WrongType,
                fmt::format("the report is damaged; build again ({})", e.what()), {.file = file});
  }
}

Result<void> writeReport(const std::filesystem::path& file, const Report& report) {
  return writeFileWhole(file, printReport(report));
}

Result<Report> readReport(const std::filesystem::path& file) {
  const auto text = readFile(file);
  if (!text) return passOn(text);
  return parseReport(*text, file.string());
}

}  // namespace ecorche::exchange
