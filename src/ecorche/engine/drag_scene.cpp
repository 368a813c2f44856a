#include <ecorche/engine/build.h>
#include <ecorche/engine/drag_scene.h>
#include <ecorche/engine/inputs.h>
#include <ecorche/model/project_check.h>
#include <fmt/format.h>

#include <algorithm>

namespace ecorche::engine {

namespace {

Result<tissue::CurveRef> find(const std::vector<tissue::CurveTissue>& tissues,
                              const DragScript& script) {
  const auto there = std::ranges::find(tissues, script.muscle, &tissue::CurveTissue::name);
  if (there == tissues.end() || script.curve >= there->curves.size() ||
      script.point >= there->curves[script.curve].values.size()) {
    return fail(
        ErrorCode::UnknownName,
        fmt::format("drag \"{}\": there is no muscle \"{}\" with a curve {} of {} points or "
                    "more; name one of the project's",
                    script.name, script.muscle, script.curve + 1, script.point + 1),
        {.object = script.name});
  }
  return tissue::CurveRef{static_cast<std::size_t>(there - tissues.begin()),
                          static_cast<std::int32_t>(script.curve)};
}

}  // namespace

mesh::Vector3 DragScript::offset(int frame) const {
  if (path.size() < 2) return mesh::Vector3::Zero();
  const mesh::Spline way(path);
  return way.at(way.parameterAt(way.length() * frame / frames)) - path.front();
}

mesh::Spline DragScene::splineAt(const DragScript& script, tissue::CurveRef curve,
                                 int frame) const {
  auto points = tissues[curve.tissue].curves[static_cast<std::size_t>(curve.curve)].spline.points();
  points[script.point] += domain->skinDiagonal * script.offset(frame);
  return mesh::Spline(points);
}

Result<DragScene> prepareDragScene(const model::Project& project, std::optional<std::int64_t> tets,
                                   const std::vector<DragScript>& scripts, RunContext& run) {
  if (auto sound = model::checkProject(project); !sound) return passOn(sound);
  DragScene out;
  out.tissues = curveTissues(project);
  out.how = tissueOptions(project);
  for (const DragScript& script : scripts) {
    const auto there = find(out.tissues, script);
    if (!there) return passOn(there);
    out.curves.push_back(*there);
  }
  auto prepared = prepareDomain(project, {.tets = tets}, run);
  if (!prepared) return passOn(prepared);
  out.domain = std::make_shared<const domain::Domain>(std::move(prepared->build.domain));
  auto made = tissue::TissueSolver::create(*out.domain, run);
  if (!made) return passOn(made);
  out.solver = std::make_shared<const tissue::TissueSolver>(std::move(*made));
  out.walker = std::make_shared<const tissue::CurveWalker>(*out.domain);
  return out;
}

}  // namespace ecorche::engine
