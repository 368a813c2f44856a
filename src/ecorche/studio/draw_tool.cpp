#include <ecorche/studio/draw_tool.h>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

constexpr double kStep = 3.0;         // between samples of a stroke [pixels]
constexpr double kShortest = 8.0;     // of a stroke [pixels]
constexpr double kCurveReach = 10.0;  // [pixels]

QString nameOf(const model::Support& support) { return QString::fromStdString(support.name); }

}  // namespace

std::optional<CurveTip> DrawTool::tipAt(const Eigen::Vector2d& pixel) const {
  const auto& meshes = session().meshes();
  if (!meshes) return std::nullopt;
  const authoring::SightRay sight = view_.camera.sight(pixel);
  if (const auto bone = boneUnder(sight, *meshes, session().project(), session().display()))
    return CurveTip{{model::Support::On::Bone, bone->bone}, bone->at};
  if (onMuscles_) {
    double nearest = kCurveReach;
    std::optional<CurveTip> best;
    for (const model::Tissue& tissue : session().project().tissues) {
      for (const model::Curve& curve : tissue.curves) {
        const mesh::Spline spline = model::splineOf(curve);
        for (int k = 0; k <= 60; ++k) {
          const Vector3 p = spline.at(spline.lastParameter() * k / 60.0);
          const auto seen = view_.camera.pixelOf(p);
          if (!seen || (*seen - pixel).norm() > nearest) continue;
          nearest = (*seen - pixel).norm();
          best = CurveTip{{model::Support::On::Tissue, tissue.name}, p};
        }
      }
    }
    if (best) return best;
  }
  if (onPlanes_ && meshes->skin) {
    for (const model::CutPlane& plane : session().project().cutPlanes) {
      const double slope = plane.normal.dot(sight.direction);
      if (std::abs(slope) < 1e-3) continue;  // seen edge-on: any place would do
      const double t = plane.normal.dot(plane.point - sight.origin) / slope;
      const Vector3 p = sight.origin + t * sight.direction;
      if (t > 0.0 && meshes->skin->inside(p))
        return CurveTip{{model::Support::On::Plane, plane.name}, p};
    }
  }
  return std::nullopt;
}

void DrawTool::hover(const Touch& touch) {
  const auto tip = tipAt(touch.pixel);
  over_ = tip ? nameOf(tip->support) : QString();
  Overlay overlay;
  if (tip) {
    overlay.marks.push_back(tip->at);
    if (tip->support.on == model::Support::On::Bone) overlay.hovered.bone = tip->support.name;
  }
  overlay.cursor = tip ? Qt::CrossCursor : Qt::ForbiddenCursor;
  show(overlay);
}

bool DrawTool::press(const Touch& touch) {
  from_ = tipAt(touch.pixel);
  if (!from_) return false;
  samples_.assign(1, {touch.pixel, touch.pressure.value_or(0.5)});
  pen_ = touch.pressure.has_value();
  drag(touch);
  return true;
}

void DrawTool::drag(const Touch& touch) {
  if (!from_) return;
  if ((touch.pixel - samples_.back().pixel).norm() >= kStep)
    samples_.push_back({touch.pixel, touch.pressure.value_or(0.5)});
  const auto tip = tipAt(touch.pixel);
  over_ = tip ? nameOf(tip->support) : QString();

  // Until it is over bone again the stroke is shown as far away as where it began
  const Vector3 to = tip ? tip->at : view_.camera.placeLike(from_->at, touch.pixel);
  Overlay overlay;
  overlay.stroke = shownPath(sights(), from_->at, to);
  overlay.marks.push_back(from_->at);
  if (tip) {
    overlay.marks.push_back(tip->at);
    if (tip->support.on == model::Support::On::Bone) overlay.hovered.bone = tip->support.name;
  }
  overlay.cursor = Qt::CrossCursor;
  show(overlay);
}

std::vector<authoring::SightRay> DrawTool::sights() const {
  std::vector<authoring::SightRay> out;
  for (const Sample& s : samples_) out.push_back(view_.camera.sight(s.pixel));
  return out;
}

void DrawTool::release(const Touch& touch) {
  if (!from_) return;
  if ((touch.pixel - samples_.back().pixel).norm() > 0.0)
    samples_.push_back({touch.pixel, touch.pressure.value_or(samples_.back().pressure)});
  const auto tip = tipAt(touch.pixel);
  double length = 0.0;
  for (std::size_t i = 1; i < samples_.size(); ++i)
    length += (samples_[i].pixel - samples_[i - 1].pixel).norm();
  if (length < kShortest) {
    session().tell(Severity::Note, tr("Keep the button down and draw to another bone"));
  } else if (!tip) {
    session().tell(Severity::Warning,
                   tr("The stroke has to end on a bone, so nothing was drawn: let go where the "
                      "cursor shows a cross"));
  } else {
    draw(*tip);
  }
  from_.reset();
  samples_.clear();
  hover(touch);
}

void DrawTool::draw(const CurveTip& to) {
  std::vector<double> pressures;
  if (pen_) {
    for (const Sample& s : samples_) pressures.push_back(s.pressure);
  }
  std::optional<std::string> head;
  if (const model::Tissue* selected = session().selectedTissue();
      addHead_ && selected && selected->hasCurves())
    head = selected->name;
  const DrawnMuscle drawn = drawnMuscle(session(), *from_, to, sights(), pressures, head);
  const QString name = QString::fromStdString(drawn.name);
  perform(session(), drawn, head ? tr("Draw a head of %1").arg(name) : tr("Draw %1").arg(name));
}

bool DrawTool::cancel() {
  if (!from_) return false;
  from_.reset();
  samples_.clear();
  show({});
  return true;
}

QString DrawTool::hint() const {
  if (!session().meshes()) return tr("Reading the meshes …");
  if (from_) {
    const QString start = nameOf(from_->support);
    return over_.isEmpty() ? tr("From %1: go on to another bone · Esc gives up").arg(start)
                           : tr("From %1 to %2: let go to make the muscle").arg(start, over_);
  }
  const QString what =
      addHead_ && session().selectedTissue()
          ? tr("another head of %1").arg(QString::fromStdString(session().selectedTissue()->name))
          : tr("a muscle");
  return over_.isEmpty() ? tr("Draw %1: begin over a bone").arg(what)
                         : tr("Over %1: press and draw to another bone").arg(over_);
}

}  // namespace ecorche::studio
