#include <ecorche/studio/new_muscle.h>

#include <algorithm>
#include <limits>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

constexpr double kLightest = 0.4;  // tissue value of a pen that hardly touches
constexpr double kHeaviest = 1.8;  // and of one that is pressed down

// Pressure where a control point lies along the stroke, as a tissue value
double valueAt(const Vector3& p, const std::vector<authoring::SightRay>& sights,
               const std::vector<double>& pressures) {
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < sights.size(); ++i) {
    const Vector3 off = p - sights[i].origin;
    const double distance = (off - off.dot(sights[i].direction) * sights[i].direction).norm();
    if (distance >= least) continue;
    least = distance;
    nearest = i;
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

std::vector<Vector3> shownPath(const std::vector<authoring::SightRay>& sights, const Vector3& from,
                               const Vector3& to) {
  if (sights.size() < 2) return {from, to};
  return authoring::strokeInDepth(sights, from, to);
}

DrawnMuscle drawnMuscle(const Session& session, const CurveTip& from, const CurveTip& to,
                        const std::vector<authoring::SightRay>& sights,
                        const std::vector<double>& pressures,
                        const std::optional<std::string>& tissue) {
  const std::vector<authoring::BoneSurface> none;
  const double chord = (to.at - from.at).norm();  // all there is to go by where there is no skin
  const auto& meshes = session.meshes();
  const authoring::StrokeRoom room{meshes ? meshes->skin.get() : nullptr,
                                   meshes ? meshes->bones : none, session.project().cutPlanes,
                                   std::max(meshes ? meshes->diagonal : 0.0, chord)};
  const authoring::StrokeCurve drawn =
      authoring::strokeCurve(authoring::strokeInFlesh(sights, from.at, to.at, room), room);
  model::Curve curve;
  for (const Vector3& p : drawn.points)
    curve.points.push_back({p, pressures.empty() ? 1.0 : valueAt(p, sights, pressures)});
  curve.start = from.support;
  curve.end = to.support;

  DrawnMuscle out;
  out.name = tissue ? *tissue : freshName(session.project(), "muscle");
  out.leaving = drawn.leaving;
  if (!tissue) out.commands.push_back(model::AddMuscle{out.name});
  out.commands.push_back(model::AddCurve{out.name, std::move(curve)});
  return out;
}

bool perform(Session& session, const DrawnMuscle& drawn, const QString& label) {
  if (!session.perform(drawn.commands, label)) return false;
  session.select({drawn.name, -1, -1, {}});
  if (!drawn.leaving) return true;
  const QString name = QString::fromStdString(drawn.name);
  const QString what = QString::fromStdString(drawn.leaving->name);
  using Through = authoring::Leaving::Through;
  const QString text =
      drawn.leaving->what == Through::Skin
          ? QObject::tr(
                "%1 leaves the skin: no way inside was found. Move its points (V), or draw "
                "it from another side")
                .arg(name)
          : QObject::tr(
                "%1 goes through %2: no way around was found. Move its points (V), or draw "
                "it from another side")
                .arg(name, what);
  session.tell(Severity::Warning, text, drawn.leaving->at);
  return true;
}

}  // namespace ecorche::studio
