#include <ecorche/authoring/names.h>
#include <ecorche/authoring/snap.h>
#include <ecorche/studio/edits.h>
#include <ecorche/studio/new_muscle.h>

#include <QObject>
#include <algorithm>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

QString shown(const std::string& name) { return QString::fromStdString(name); }

const model::Curve* selectedCurve(const Session& session) {
  const model::Tissue* tissue = session.selectedTissue();
  const int curve = session.selection().curve;
  if (tissue == nullptr || curve < 0) return nullptr;
  return &tissue->curves[static_cast<std::size_t>(curve)];
}

// What makes a tissue of another name with these curves, and the rest as the original has it.
std::vector<model::Command> copyOf(const model::Tissue& tissue, const std::string& name,
                                   const std::vector<model::Curve>& curves) {
  std::vector<model::Command> out;
  if (tissue.kind == model::Tissue::Kind::Filler) {
    out.push_back(model::AddFiller{name});
  } else {
    out.push_back(model::AddMuscle{name});
  }
  for (const model::Curve& curve : curves) out.push_back(model::AddCurve{name, curve});
  if (tissue.colour) out.push_back(model::SetColour{name, tissue.colour});
  if (!tissue.group.empty()) out.push_back(model::SetGroup{name, tissue.group});
  if (tissue.layer) out.push_back(model::SetLayer{name, *tissue.layer});
  if (tissue.coreRadius) out.push_back(model::SetTissueCore{name, tissue.coreRadius});
  if (!(tissue.anisotropy == model::Anisotropy{}))
    out.push_back(model::SetAnisotropy{name, tissue.anisotropy});
  return out;
}

}  // namespace

Edit removeSelected(const Session& session) {
  const model::Tissue* tissue = session.selectedTissue();
  if (tissue == nullptr) return {};
  const Selection& s = session.selection();
  const auto curve = static_cast<std::size_t>(std::max(0, s.curve));
  if (s.point >= 0 && tissue->curves[curve].points.size() > 2) {
    return {{model::RemovePoint{tissue->name, curve, static_cast<std::size_t>(s.point)}},
            QObject::tr("Remove a point of %1").arg(shown(tissue->name)),
            {tissue->name, s.curve, -1, {}}};
  }
  if (s.curve >= 0 && tissue->curves.size() > 1) {
    return {{model::RemoveCurve{tissue->name, curve}},
            QObject::tr("Remove a head of %1").arg(shown(tissue->name)),
            {tissue->name, -1, -1, {}}};
  }
  return {
      {model::RemoveTissue{tissue->name}}, QObject::tr("Delete %1").arg(shown(tissue->name)), {}};
}

Edit insertPoint(const Session& session, const Vector3& near) {
  const model::Curve* curve = selectedCurve(session);
  if (curve == nullptr) return {};
  const mesh::Spline spline = model::splineOf(*curve);
  constexpr int kSteps = 400;
  double best = 0.0;
  for (int k = 1; k < kSteps; ++k) {
    const double u = spline.lastParameter() * k / kSteps;
    if (best == 0.0 || (spline.at(u) - near).norm() < (spline.at(best) - near).norm()) best = u;
  }
  const auto place = static_cast<std::size_t>(best) + 1;
  const std::string& name = session.selection().tissue;
  const model::ControlPoint point{spline.at(best),
                                  spline.interpolate(model::tissueValuesOf(*curve), best)};
  return {
      {model::InsertPoint{name, static_cast<std::size_t>(session.selection().curve), place, point}},
      QObject::tr("Insert a point in %1").arg(shown(name)),
      {name, session.selection().curve, static_cast<int>(place), {}}};
}

Edit splitCurve(const Session& session) {
  const model::Curve* curve = selectedCurve(session);
  const int point = session.selection().point;
  if (curve == nullptr || point <= 0 || point + 1 >= std::ssize(curve->points)) return {};
  const auto at = static_cast<std::size_t>(point);
  const auto index = static_cast<std::size_t>(session.selection().curve);
  const std::string& name = session.selection().tissue;
  model::Curve second = *curve;
  second.points.erase(second.points.begin(), second.points.begin() + point);
  second.start = {};
  // Heads of one muscle have names of their own, or none
  if (!second.name.empty()) second.name += QObject::tr(", second half").toStdString();
  const std::vector<model::ControlPoint> first(curve->points.begin(),
                                               curve->points.begin() + point + 1);
  return {{model::SetCurvePoints{name, index, first}, model::SetCurveEnd{name, index, {}},
           model::AddCurve{name, second}},
          QObject::tr("Split %1").arg(shown(name)),
          {name, static_cast<int>(index), static_cast<int>(at), {}}};
}

Edit duplicate(const Session& session) {
  const model::Tissue* tissue = session.selectedTissue();
  if (tissue == nullptr || !tissue->hasCurves()) return {};
  const std::string name = freshName(session.project(), tissue->name);
  return {copyOf(*tissue, name, tissue->curves),
          QObject::tr("Duplicate %1").arg(shown(tissue->name)),
          {name, -1, -1, {}}};
}

Edit protectSelected(const Session& session, bool on) {
  const model::Tissue* tissue = session.selectedTissue();
  if (tissue == nullptr) return {};
  return {{model::SetProtected{tissue->name, on}},
          (on ? QObject::tr("Protect %1") : QObject::tr("Lift the protection of %1"))
              .arg(shown(tissue->name)),
          session.selection()};
}

Edit keepTwinOfSelected(const Session& session, bool on) {
  const model::Tissue* tissue = session.selectedTissue();
  if (tissue == nullptr) return {};
  return {
      {model::SetKeepsTwin{tissue->name, on}},
      (on ? QObject::tr("Keep the twin of %1 in step") : QObject::tr("Let go of the twin of %1"))
          .arg(shown(tissue->name)),
      session.selection()};
}

Edit thicken(const Session& session, double factor) {
  const model::Tissue* tissue = session.selectedTissue();
  if (tissue == nullptr) return {};
  Edit out{{}, QObject::tr("Thickness of %1").arg(shown(tissue->name)), session.selection()};
  for (std::size_t c = 0; c < tissue->curves.size(); ++c) {
    for (std::size_t p = 0; p < tissue->curves[c].points.size(); ++p)
      out.commands.push_back(
          model::SetPointValue{tissue->name, c, p, tissue->curves[c].points[p].tissue * factor});
  }
  return out;
}

Edit mirrored(const Session& session, const MirrorPlane& plane) {
  const model::Tissue* tissue = session.selectedTissue();
  if (tissue == nullptr || !tissue->hasCurves() || tissue->curves.empty()) return {};
  const model::Project& project = session.project();
  Edit out;
  std::string source = tissue->name;
  auto twin = authoring::mirroredName(source);
  if (!twin) {
    // A name without a side: the muscle gets the side that it lies on. Left is where +Y is, as for
    // a body that looks along +X with Z up
    double height = 0.0;
    for (const auto& p : tissue->curves.front().points)
      height += (p.at - plane.point).dot(plane.normal);
    const bool left = (height > 0.0) == (plane.normal.sum() > 0.0);
    const std::string sided = freshName(project, source + (left ? "_L" : "_R"));
    out.commands.push_back(model::RenameTissue{source, sided});
    out.commands.push_back(model::SetSide{sided, left ? model::Side::Left : model::Side::Right});
    twin = source + (left ? "_R" : "_L");
    source = sided;
  }
  const auto image = imageOf(project, session.meshes().get(), *tissue, *twin, plane);
  out.commands.insert(out.commands.end(), image.begin(), image.end());
  out.label = QObject::tr("Mirror %1").arg(shown(tissue->name));
  out.select = {source, -1, -1, {}};
  return out;
}

}  // namespace ecorche::studio
