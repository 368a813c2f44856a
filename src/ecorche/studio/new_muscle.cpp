#include <ecorche/studio/new_muscle.h>

#include <algorithm>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

constexpr double kLightest = 0.4;  // tissue value of a pen that hardly touches
constexpr double kHeaviest = 1.8;  // and of one that is pressed down

// Pressure where a control point lies along the path, as a tissue value
double valueAt(const Vector3& p, const std::vector<Vector3>& path,
               const std::vector<double>& pressures) {
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    if ((path[i] - p).squaredNorm() < (path[nearest] - p).squaredNorm()) nearest = i;
  }
  return kLightest + (kHeaviest - kLightest) * std::clamp(pressures[nearest], 0.0, 1.0);
}

}  // namespace

std::string freshName(const model::Project& project, const std::string& wanted) {
  if (!model::findTissue(project, wanted)) return wanted;
  for (int k = 2;; ++k) {
    const std::string name = wanted + " " + std::to_string(k);
    if (!model::findTissue(project, name)) return name;
  }
}

DrawnMuscle drawnMuscle(const Session& session, const CurveTip& from, const CurveTip& to,
                        const std::vector<Vector3>& path, const std::vector<double>& pressures,
                        const std::optional<std::string>& tissue) {
  std::vector<Vector3> points;
  const auto& meshes = session.meshes();
  if (meshes && meshes->skin) {
    const authoring::Surroundings around{
        *meshes->skin, meshes->bones, meshes->diagonal, {}, {}, false, {}};
    points = authoring::strokeCurve(path, around);
  } else {
    points = authoring::fittedStroke(path);
  }
  model::Curve curve;
  for (const Vector3& p : points)
    curve.points.push_back({p, pressures.empty() ? 1.0 : valueAt(p, path, pressures)});
  curve.start = from.support;
  curve.end = to.support;

  DrawnMuscle out;
  out.name = tissue ? *tissue : freshName(session.project(), "muscle");
  if (!tissue) out.commands.push_back(model::AddMuscle{out.name});
  out.commands.push_back(model::AddCurve{out.name, std::move(curve)});
  return out;
}

}  // namespace ecorche::studio
