#include <ecorche/engine/picture.h>
#include <ecorche/engine/view_bench.h>
#include <ecorche/render/anatomy_scene.h>
#include <ecorche/render/offscreen.h>
#include <ecorche/render/paper_volume.h>
#include <ecorche/render/ray_caster.h>
#include <ecorche/render/renderer.h>
#include <ecorche/tissue/solve_tissues.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numbers>
#include <tuple>

namespace ecorche::engine {

namespace {

using render::Scene;
using render::VolumeItem;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double processorNow() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// @param processor  spent by all threads over all of them
FrameTimes timesOf(std::vector<double> seconds, double processor) {
  std::ranges::sort(seconds);
  const auto at = [&](double share) {
    return seconds[static_cast<std::size_t>(share * static_cast<double>(seconds.size() - 1))];
  };
  return {at(0.5), at(0.95), seconds.back(), processor / static_cast<double>(seconds.size())};
}

// The curve in the middle of the list, sideways by 1 % of the diagonal: fields there take new
// values where they change by more than a thousandth.
Result<double> moveCurve(const model::Project& project, const domain::Domain& domain,
                         VolumeItem& item, RunContext& run) {
  const std::vector<std::size_t> places = curveTissuePlaces(project);
  const double step = 0.01 * domain.skinDiagonal;
  // Some ways lead out of the skin: the first that does not
  Result<tissue::SolvedTissues> solved;
  for (const mesh::Vector3& way : {mesh::Vector3(0.0, 0.6, 0.8), mesh::Vector3(0.0, -0.6, -0.8),
                                   mesh::Vector3(1.0, 0.0, 0.0), mesh::Vector3(-1.0, 0.0, 0.0)}) {
    model::Project moved = project;
    for (auto& point : moved.tissues[places[places.size() / 2]].curves.front().points)
      point.at += step * way;
    solved = tissue::solveTissues(domain, curveTissues(moved), tissueOptions(moved), run);
    if (solved || run.cancelled()) break;
  }
  if (!solved) return passOn(solved);
  auto values = std::make_shared<tissue::FieldMatrix>(*item.fields);
  auto changed = std::make_shared<render::FieldChange>();
  for (Eigen::Index c = 0; c < values->cols(); ++c)
    changed->columns.push_back(static_cast<std::int32_t>(c));
  const double least = 1e-3 * solved->fields.maxValue;
  for (Eigen::Index v = 0; v < values->rows(); ++v) {
    if ((solved->fields.values.row(v) - values->row(v)).cwiseAbs().maxCoeff() <= least) continue;
    values->row(v) = solved->fields.values.row(v);
    changed->vertices.push_back(static_cast<std::int32_t>(v));
  }
  item.fields = values;
  item.changed = changed;
  ++item.fieldsRevision;
  return static_cast<double>(changed->vertices.size()) / static_cast<double>(values->rows());
}

render::Camera cameraFrom(const VolumeItem& item, const ViewBenchOptions& options,
                          double azimuthDeg, double elevationDeg) {
  const mesh::Box box = item.geometry->box();
  return render::framed({azimuthDeg, elevationDeg, 24.0, 1.0}, render::guessedAxes(box, options.up),
                        box, static_cast<double>(options.width) / options.height, 0.03);
}

constexpr std::tuple<double, double> kSides[] = {{25.0, 12.0}, {150.0, -20.0}, {265.0, 55.0}};

Result<void> compare(render::Renderer& renderer, const VolumeItem& whole,
                     const ViewBenchOptions& options, ViewCase& out) {
  for (const bool someHidden : {false, true}) {
    VolumeItem item = whole;
    for (std::size_t i = 2; someHidden && i < item.tissues.size(); i += 2)
      item.tissues[i].visible = item.tissues[i].inCut = false;
    for (const bool cut : {false, true}) {
      Scene scene;
      scene.volume = item;
      if (cut)
        scene.clip = render::ClipPlane{item.geometry->box().centre(),
                                       mesh::Vector3(0.6, 0.7, -0.3).normalized()};
      for (const auto& [azimuth, elevation] : kSides) {
        render::PictureOptions how;
        how.width = options.width / 2;
        how.height = options.height / 2;
        how.motion = true;
        const render::Camera camera = cameraFrom(item, options, azimuth, elevation);
        if (auto ok = renderer.begin(scene, camera, how); !ok) return ok;
        renderer.pass();
        const auto a =
            render::agreement(renderer.readTissues(),
                              render::castImage(camera, how.width, how.height, item, scene.clip));
        out.sameTissue = std::min(out.sameTissue, a.sameTissue);
        out.normalsClose = std::min(out.normalsClose, a.normalsClose);
      }
    }
  }
  return {};
}

Result<void> drawPaper(const VolumeItem& item, const ViewBenchOptions& options, ViewCase& out) {
  auto paper = render::PaperVolume::create(item, options.width, options.height);
  if (!paper) return passOn(paper);
  std::vector<double> seconds;
  double processor = 0.0;
  for (const auto& [azimuth, elevation] : kSides) {
    const render::Camera camera = cameraFrom(item, options, azimuth, elevation);
    const double begin = now();
    const double spent = processorNow();
    paper->draw(camera);
    seconds.push_back(now() - begin);
    processor += processorNow() - spent;
    const auto a = render::agreement(
        paper->read(), render::castImage(camera, options.width, options.height, item));
    out.paperSameTissue = std::min(out.paperSameTissue, a.sameTissue);
  }
  out.paper = timesOf(seconds, processor);
  return {};
}

Result<ViewCase> measure(const model::Project& project, const Preview& preview,
                         const ViewBenchOptions& options, RunContext& run) {
  ViewCase out;
  const domain::Domain& domain = preview.domain.build.domain;
  out.tets = domain.mesh.T.rows();
  const double begin = now();
  const PictureModel model = pictureModel(project, preview);
  out.prepare = now() - begin;
  out.muscles = model.tissues.size() - 1;

  Scene scene;
  scene.volume = model.volume;
  for (std::size_t i = 0; i < scene.volume->tissues.size(); ++i)
    scene.volume->tissues[i].inCut = true;
  scene.volume->tissues[0].visible = false;
  scene.volume->fieldsRevision = 1;
  scene.volume->flow = nullptr;  // without streaks, as a rule
  auto context = render::OffscreenContext::create();
  if (!context) return passOn(context);
  auto renderer = render::Renderer::create();
  if (!renderer) return passOn(renderer);
  render::PictureOptions how;
  how.width = options.width;
  how.height = options.height;
  how.motion = true;

  // Muscles alone: the first frame makes and sends everything
  double start = now();
  if (auto ok = renderer->begin(scene, cameraFrom(*scene.volume, options, 0.0, 12.0), how); !ok)
    return passOn(ok);
  out.firstUpload = now() - start;
  renderer->pass();
  out.fullBytes = renderer->volumeUploads().content;
  out.drawnTets = renderer->volumeUploads().tets;

  const auto frames = [&](const Scene& what, bool lit) -> Result<FrameTimes> {
    std::vector<double> seconds;
    double processor = 0.0;
    for (int i = -1; i < options.frames; ++i) {
      const double from = now();
      if (i == 0) processor = processorNow();
      const auto camera = cameraFrom(*scene.volume, options, 360.0 * i / options.frames, 12.0);
      if (auto ok = renderer->begin(what, camera, how); !ok) return passOn(ok);
      if (lit) {
        renderer->pass();
        (void)renderer->read();
      } else {
        renderer->passUnlit();
      }
      if (i >= 0) seconds.push_back(now() - from);
    }
    return timesOf(seconds, processorNow() - processor);
  };
  auto steps = frames(scene, false);
  if (!steps) return passOn(steps);
  out.steps = *steps;

  Scene full = scene;
  for (const auto& bone : model.bones)
    full.surfaces.push_back(render::surfaceItem(render::Material::Bone, bone.mesh));
  full.surfaces.push_back(render::surfaceItem(render::Material::Skin, model.skin.mesh));
  auto lit = frames(full, true);
  if (!lit) return passOn(lit);
  out.frame = *lit;
  out.triangles = renderer->volumeUploads().triangles;
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped between measurements");

  if (auto ok = compare(*renderer, *scene.volume, options, out); !ok) return passOn(ok);
  if (auto ok = renderer->begin(scene, cameraFrom(*scene.volume, options, 0.0, 12.0), how); !ok)
    return passOn(ok);

  const auto share = moveCurve(project, domain, *scene.volume, run);
  if (!share) return passOn(share);
  out.editShare = *share;
  start = now();
  if (auto ok = renderer->begin(scene, cameraFrom(*scene.volume, options, 0.0, 12.0), how); !ok)
    return passOn(ok);
  out.editUpload = now() - start;
  out.editBytes = renderer->volumeUploads().content;

  // Rays that meet something: those that pass by cost nothing
  const render::Camera camera = cameraFrom(*scene.volume, options, 25.0, 12.0);
  double spent = 0.0;
  int met = 0;
  for (int y = 8; y < options.height; y += 16)
    for (int x = 8; x < options.width; x += 16) {
      start = now();
      const bool hit =
          render::castRay(render::rayThrough(camera, options.width, options.height, {x, y}),
                          *scene.volume)
              .has_value();
      const double took = now() - start;
      spent += hit ? took : 0.0;
      met += hit ? 1 : 0;
    }
  out.pick = spent / std::max(1, met);

  if (options.paper && !run.cancelled()) {
    scene.volume->fields = model.volume->fields;
    if (auto ok = drawPaper(*scene.volume, options, out); !ok) return passOn(ok);
  }
  return out;
}

}  // namespace

Result<std::vector<ViewCase>> benchView(const model::Project& project,
                                        const ViewBenchOptions& options, RunContext& run) {
  std::vector<ViewCase> out;
  for (const bool adaptive : {true, false}) {
    if (!adaptive && !options.uniform) break;
    BuildOptions build;
    build.tets = options.tets;
    build.sizing = adaptive ? Sizing::Draft : Sizing::None;
    auto preview = preparePreview(project, build, run);
    if (!preview) return passOn(preview);
    auto measured = measure(project, *preview, options, run);
    if (!measured) return passOn(measured);
    measured->name = adaptive ? "adaptive" : "uniform";
    out.push_back(std::move(*measured));
    if (run.cancelled()) return fail(ErrorCode::Cancelled, "stopped between two domains");
  }
  return out;
}

}  // namespace ecorche::engine
