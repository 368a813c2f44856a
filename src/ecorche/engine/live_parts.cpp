#include <ecorche/engine/live_parts.h>

#include <utility>

namespace ecorche::engine {

namespace {

// What a field is solved for, and nothing else.
void blankAllButCurves(model::Tissue& tissue) {
  tissue.name.clear();
  tissue.side = model::Side::Unknown;
  tissue.group.clear();
  tissue.layer.reset();
  tissue.colour.reset();
  tissue.isProtected = false;
  tissue.keepsTwin = false;
  tissue.attachments.clear();
  for (model::Curve& curve : tissue.curves) {
    curve.name.clear();
    curve.start = {};
    curve.end = {};
    for (model::ControlPoint& point : curve.points) point.tissue = 1.0;
  }
}

}  // namespace

model::Project meshPart(const model::Project& project) {
  model::Project out;
  out.folder = project.folder;
  out.unit = project.unit;
  out.skin = project.skin;
  out.bones = project.bones;
  for (const model::Tissue& tissue : project.tissues) {
    if (!tissue.mesh) continue;
    model::Tissue mesh;
    mesh.name = tissue.name;
    mesh.kind = tissue.kind;
    mesh.mesh = tissue.mesh;
    out.tissues.push_back(std::move(mesh));
  }
  return out;
}

model::Project domainPart(const model::Project& project) {
  model::Project out = meshPart(project);
  out.cutPlanes = project.cutPlanes;
  out.settings.tets = project.settings.tets;
  out.settings.edgeLength = project.settings.edgeLength;
  out.settings.surfaceTolerance = project.settings.surfaceTolerance;
  return out;
}

model::Project curvePart(const model::Project& project) {
  model::Project out = domainPart(project);
  out.settings.coreRadius = project.settings.coreRadius;
  out.settings.alpha = project.settings.alpha;
  for (const std::size_t place : liveTissuePlaces(project)) {
    out.tissues.push_back(project.tissues[place]);
    blankAllButCurves(out.tissues.back());
  }
  return out;
}

std::vector<std::size_t> liveTissuePlaces(const model::Project& project) {
  std::vector<std::size_t> places;
  for (std::size_t t = 0; t < project.tissues.size(); ++t) {
    if (project.tissues[t].hasCurves() && !project.tissues[t].curves.empty()) places.push_back(t);
  }
  return places;
}

}  // namespace ecorche::engine
