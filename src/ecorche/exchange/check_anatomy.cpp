#include <ecorche/exchange/check_anatomy.h>
#include <ecorche/exchange/check_parts.h>
#include <ecorche/exchange/medit.h>
#include <ecorche/exchange/vtu.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

namespace ecorche::exchange {

namespace fs = std::filesystem;

Eigen::Vector3d CheckedFiles::centroid(std::int64_t t) const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = 0; k < 4; ++k) sum += 0.25 * anatomy->mesh.V.row(anatomy->mesh.T(t, k)).transpose();
  return sum;
}

const TissueRecord* CheckedFiles::tissue(std::int32_t id) const {
  const auto at = std::ranges::find(record.tissues, id, &TissueRecord::id);
  return at == record.tissues.end() ? nullptr : &*at;
}

namespace {

Result<CheckedFiles> readFiles(const fs::path& folder) {
  CheckedFiles files;
  files.folder = folder;
  auto record = readModelRecord(folder / "model.json");
  if (!record) return passOn(record);
  files.record = std::move(*record);
  if (fs::exists(folder / "anatomy.vtu")) {
    auto vtu = readVtu(folder / "anatomy.vtu");
    if (!vtu) return passOn(vtu);
    files.vtu = std::move(*vtu);
  }
  if (fs::exists(folder / "anatomy.mesh")) {
    auto medit = readMedit(folder / "anatomy.mesh");
    if (!medit) return passOn(medit);
    files.medit = std::move(*medit);
  }
  if (!files.vtu && !files.medit) {
    return fail(ErrorCode::FileMissing,
                "the folder has neither anatomy.vtu nor anatomy.mesh; build with one of them",
                {.file = folder.string()});
  }
  return files;
}

// What follows from the tets alone.
void derive(CheckedFiles& files) {
  files.anatomy = files.vtu ? &*files.vtu : &*files.medit;
  const AnatomyFile& a = *files.anatomy;
  files.adjacency = mesh::tetAdjacency(a.mesh.T);
  files.volume = mesh::signedVolumes(a.mesh);
  files.boundary = mesh::tetBoundary(a.mesh.T, files.adjacency.neighbours);
  std::int32_t last = 0;
  for (const TissueRecord& t : files.record.tissues) last = std::max(last, t.id);
  files.tetsOf.resize(static_cast<std::size_t>(last) + 1);
  for (std::size_t t = 0; t < a.tissue.size(); ++t) {
    const std::int32_t id = a.tissue[t];
    if (id >= 0 && id <= last)
      files.tetsOf[static_cast<std::size_t>(id)].push_back(static_cast<std::int32_t>(t));
  }
}

void checkFilesComplete(const CheckedFiles& files, Checks& checks) {
  Check c{"files-complete"};
  std::int64_t named = 0;
  const auto look = [&](const std::string& file) {
    if (file.empty()) return;
    ++named;
    if (fs::exists(files.folder / file)) return;
    c.value += 1.0;
    c.object = file;
  };
  for (const TissueRecord& t : files.record.tissues) look(t.file);
  for (const SurfaceRecord& s : files.record.surfaces) look(s.file);
  c.pass = c.value == 0.0;
  c.detail = c.pass ? fmt::format("all {} surfaces that model.json names are there", named)
                    : fmt::format("{} of {} surfaces are missing, among them {}", c.value, named,
                                  c.object);
  checks.push_back(std::move(c));
}

// The report's volumes against those of the files.
Result<void> checkReportAgrees(const CheckedFiles& files, CheckReport& report) {
  const fs::path file = files.folder / "report.json";
  if (!fs::exists(file)) return {};
  const auto written = readReport(file);
  if (!written) return passOn(written);
  Check c{"report-agrees"};
  c.limit = 1e-9;
  for (const TissueFigures& own : report.tissues) {
    const auto at = std::ranges::find(written->tissues, own.id, &TissueFigures::id);
    double off = own.volumeCm3 == 0.0 ? 0.0 : INFINITY;
    if (at != written->tissues.end() && own.volumeCm3 > 0.0) {
      off = std::abs(at->volumeCm3 - own.volumeCm3) / own.volumeCm3;
    }
    if (!(off <= c.value)) {
      c.value = off;
      c.object = own.name;
    }
  }
  c.pass = c.value <= c.limit;
  c.detail = c.pass ? "volumes in report.json are those of the files"
                    : fmt::format("the volume of \"{}\" in report.json is not that of the files",
                                  c.object);
  report.checks.push_back(std::move(c));
  return {};
}

}  // namespace

bool CheckReport::pass() const { return std::ranges::all_of(checks, &Check::pass); }

Result<CheckReport> checkOutput(const fs::path& folder, RunContext& run,
                                const CheckOptions& options) {
  const Stage stage(run, "checking files");
  auto files = readFiles(folder);
  if (!files) return passOn(files);
  derive(*files);
  CheckReport report;
  report.tets = files->anatomy->mesh.T.rows();
  report.vertices = files->anatomy->mesh.V.rows();
  checkFilesComplete(*files, report.checks);
  // Without its surfaces there is nothing to compare
  if (!report.pass()) return report;
  run.progress("checking files", 0.3);
  checkTets(*files, report.checks);
  run.progress("checking files", 0.5);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "checking files");
  if (auto ok = checkMuscles(*files, report, run); !ok) return passOn(ok);
  checkFibers(*files, report.checks);
  run.progress("checking files", 0.7);
  if (options.deviation) {
    if (auto ok = checkDeviation(*files, report.checks, run); !ok) return passOn(ok);
  }
  if (auto ok = checkReportAgrees(*files, report); !ok) return passOn(ok);
  return report;
}

std::optional<Error> failure(const CheckReport& report, const fs::path& folder) {
  Error error;
  error.code = ErrorCode::CheckFailed;
  error.place.file = folder.string();
  std::int64_t count = 0;
  for (const Check& c : report.checks) {
    if (c.pass) continue;
    error.message += fmt::format("{}{}: {}", count++ == 0 ? "" : "; ", c.name, c.detail);
    if (error.place.object.empty()) error.place.object = c.object;
    if (!error.place.point) error.place.point = c.point;
  }
  if (count == 0) return std::nullopt;
  error.message =
      fmt::format("{} of {} checks failed: {}", count, report.checks.size(), error.message);
  return error;
}

std::string printCheckReport(const CheckReport& report) {
  nlohmann::ordered_json j{
      {"pass", report.pass()}, {"tets", report.tets}, {"vertices", report.vertices}};
  j["checks"] = nlohmann::ordered_json::array();
  for (const Check& c : report.checks) {
    nlohmann::ordered_json entry{{"name", c.name},
                                 {"pass", c.pass},
                                 {"value", c.value},
                                 {"limit", c.limit},
                                 {"detail", c.detail}};
    if (!c.object.empty()) entry["object"] = c.object;
    if (c.point) entry["point_m"] = {c.point->x(), c.point->y(), c.point->z()};
    j["checks"].push_back(std::move(entry));
  }
  j["tissues"] = nlohmann::ordered_json::array();
  for (const TissueFigures& t : report.tissues) {
    j["tissues"].push_back({{"id", t.id},
                            {"name", t.name},
                            {"volume_cm3", t.volumeCm3},
                            {"area_cm2", t.areaCm2},
                            {"components", t.components},
                            {"tets", t.tets}});
  }
  return j.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace ecorche::exchange
