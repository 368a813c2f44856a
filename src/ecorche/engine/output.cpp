#include <ecorche/engine/output.h>
#include <ecorche/engine/picture.h>
#include <ecorche/engine/report.h>
#include <ecorche/render/image.h>

#include <thread>

namespace ecorche::engine {

Result<StagedFolder> stageOutput(const std::filesystem::path& folder) {
  return StagedFolder::create(
      folder, {"report.json",
               {"report.json", "model.json", "anatomy.vtu", "anatomy.mesh", "skin.obj", "fat.obj",
                "muscles", "bones", "others", "preview.png"}});
}

namespace {

Result<exchange::WrittenOutput> writeFiles(const model::Project& project, const Build& build,
                                           const std::filesystem::path& folder,
                                           const OutputOptions& options, RunContext& run) {
  const Stage stage(run, "write");
  std::vector<mesh::SurfaceMesh> surfaces;
  for (const auto& s : build.surfaces) surfaces.push_back(s.mesh);
  std::vector<exchange::OriginalSurface> originals{{"skin", "skin", &build.meshes.skin}};
  for (const auto& m : build.meshes.bones) originals.push_back({m.name, "bone", &m});
  for (const auto& m : build.meshes.obstacles) originals.push_back({m.name, "obstacle", &m});
  for (const auto& m : build.meshes.cavities) originals.push_back({m.name, "cavity", &m});
  const std::vector<domain::CutPlane> planes = cutPlanes(project);
  const exchange::OutputContents contents{
      build.anatomy, build.domain.domain, build.tissues, build.fibers,
      surfaces,      originals,           planes,        project.settings.surfaceTolerance};
  return exchange::writeOutput(folder, contents, options.formats, run);
}

// Where there is no graphics a finding says so, and the build is none the worse.
Result<void> writePreview(const model::Project& project, const Build& build,
                          const std::filesystem::path& folder, Findings& findings,
                          RunContext& run) {
  const Stage stage(run, "preview");
  PictureSettings settings;
  settings.width = 1200;
  settings.height = 900;
  settings.samples = 8;
  settings.hide = {"skin"};
  const auto picture = drawPicture(project, build, settings, run);
  if (picture) return render::writePng(folder / "preview.png", *picture);
  if (picture.error().code != ErrorCode::NoGraphics) return passOn(picture);
  findings.push_back(
      {.severity = Severity::Warning, .kind = "no-preview", .message = picture.error().text()});
  return {};
}

}  // namespace

Result<exchange::Report> writeBuild(const model::Project& project, const Build& build,
                                    const std::filesystem::path& folder,
                                    const OutputOptions& options, RunContext& run) {
  auto staged = stageOutput(folder);
  if (!staged) return passOn(staged);

  // One waits for the disk and formats numbers, the other for the graphics card
  Result<void> pictured;
  Findings findings;
  Result<exchange::WrittenOutput> written;
  {
    const Stage stage(run, "output");
    std::jthread painter;
    if (options.preview)
      painter = std::jthread(
          [&] { pictured = writePreview(project, build, staged->path(), findings, run); });
    written = writeFiles(project, build, staged->path(), options, run);
  }
  if (!written) return passOn(written);
  if (!pictured) return passOn(pictured);
  exchange::Report report = makeReport(project, build, *written, run);
  report.findings.insert(report.findings.end(), findings.begin(), findings.end());
  report.totalSeconds = run.seconds();
  if (auto saved = exchange::writeReport(staged->path() / "report.json", report); !saved)
    return passOn(saved);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped; nothing was written");
  if (auto done = staged->commit(); !done) return passOn(done);
  return report;
}

}  // namespace ecorche::engine
