#include <ecorche/engine/output.h>
#include <ecorche/engine/picture.h>
#include <ecorche/engine/report.h>
#include <ecorche/render/image.h>

namespace ecorche::engine {

Result<StagedFolder> stageOutput(const std::filesystem::path& folder) {
  return StagedFolder::create(
      folder, {"report.json",
               {"report.json", "model.json", "anatomy.vtu", "anatomy.mesh", "skin.obj", "fat.obj",
                "muscles", "bones", "others", "preview.png"}});
}

Result<exchange::Report> writeBuild(const model::Project& project, const Build& build,
                                    const std::filesystem::path& folder,
                                    const OutputOptions& options, RunContext& run) {
  auto staged = stageOutput(folder);
  if (!staged) return passOn(staged);

  exchange::WrittenOutput written;
  Findings findings;
  {
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
    auto files = exchange::writeOutput(staged->path(), contents, options.formats, run);
    if (!files) return passOn(files);
    written = std::move(*files);
  }
  if (options.preview) {
    const Stage stage(run, "preview");
    PictureSettings settings;
    settings.width = 1200;
    settings.height = 900;
    settings.samples = 8;
    settings.hide = {"skin"};
    auto picture = drawPicture(project, build, settings, run);
    if (picture) {
      if (auto saved = render::writePng(staged->path() / "preview.png", *picture); !saved)
        return passOn(saved);
    } else if (picture.error().code == ErrorCode::NoGraphics) {
      findings.push_back(
          {.severity = Severity::Warning, .kind = "no-preview", .message = picture.error().text()});
    } else {
      return passOn(picture);
    }
  }
  exchange::Report report = makeReport(project, build, written, run);
  report.findings.insert(report.findings.end(), findings.begin(), findings.end());
  report.totalSeconds = run.seconds();
  if (auto saved = exchange::writeReport(staged->path() / "report.json", report); !saved)
    return passOn(saved);
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped; nothing was written");
  if (auto done = staged->commit(); !done) return passOn(done);
  return report;
}

}  // namespace ecorche::engine
