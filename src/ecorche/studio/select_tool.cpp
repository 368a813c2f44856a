#include <ecorche/studio/edits.h>
#include <ecorche/studio/select_tool.h>
#include <ecorche/studio/spread_gizmo.h>

namespace ecorche::studio {

using mesh::Vector3;

namespace {

constexpr double kSlack = 3.0;        // a hand that clicks trembles [pixels]
constexpr double kSnapPixels = 24.0;  // how near is near, for Ctrl [pixels]

const model::ControlPoint* pointOf(const Session& session, const Selection& s) {
  const auto place = model::findTissue(session.project(), s.tissue);
  if (!place || s.curve < 0 || s.point < 0) return nullptr;
  const auto& curves = session.project().tissues[*place].curves;
  if (s.curve >= std::ssize(curves)) return nullptr;
  const auto& points = curves[static_cast<std::size_t>(s.curve)].points;
  return s.point < std::ssize(points) ? &points[static_cast<std::size_t>(s.point)] : nullptr;
}

// 0 start, 1 end, -1 neither
int endOf(const Session& session, const Selection& s) {
  const auto place = model::findTissue(session.project(), s.tissue);
  const auto& points =
      session.project().tissues[*place].curves[static_cast<std::size_t>(s.curve)].points;
  return s.point == 0 ? 0 : s.point + 1 == std::ssize(points) ? 1 : -1;
}

}  // namespace

std::shared_ptr<const SpreadGizmo> SelectTool::gizmo() const {
  if (!session().display().spread) return nullptr;
  const auto made = SpreadGizmo::of(session(), view_.camera);
  return made ? std::make_shared<const SpreadGizmo>(*made) : nullptr;
}

void SelectTool::hover(const Touch& touch) {
  Overlay overlay;
  const auto spread = gizmo();
  if (spread && spread->under(touch.pixel)) {
    overlay.cursor = Qt::OpenHandCursor;
  } else if (const auto handle = Picker::pickHandle(pickInput(), touch.pixel)) {
    overlay.hovered = *handle;
    overlay.cursor = handle->point >= 0 ? Qt::OpenHandCursor : Qt::PointingHandCursor;
  }
  if (overlay.hovered == overlay_.hovered && overlay.cursor == overlay_.cursor) return;
  show(overlay);
}

bool SelectTool::press(const Touch& touch) {
  if (const auto spread = gizmo()) {
    if (const auto part = spread->under(touch.pixel)) {
      held_ = Held{session().selection(), Vector3::Zero(), touch.pixel, false, spread, *part};
      Q_EMIT hintChanged();
      return true;
    }
  }
  const Selection what = Picker::pick(pickInput(), touch.pixel);
  const bool nothing = what == Selection{};
  session().select(what);
  if (nothing) return false;
  held_ = Held{what, Vector3::Zero(), touch.pixel, false, nullptr, {}};
  if (const model::ControlPoint* point = pointOf(session(), what)) held_->at = point->at;
  Q_EMIT hintChanged();
  return true;
}

std::vector<model::Command> SelectTool::moveTo(const Touch& touch) const {
  const Selection& s = held_->what;
  const auto curve = static_cast<std::size_t>(s.curve);
  const auto point = static_cast<std::size_t>(s.point);
  const int end = endOf(session(), s);
  Vector3 at = view_.camera.placeLike(held_->at, touch.pixel);
  std::optional<model::Support> support;

  if (touch.modifiers.testFlag(Qt::ShiftModifier)) {
    // Up is away from the eye
    const double by = (held_->pixel.y() - touch.pixel.y()) * view_.camera.pixelAt(held_->at);
    at = held_->at + by * view_.camera.sight(held_->pixel).direction;
    if (end >= 0) support = model::Support{};
  } else if (touch.modifiers.testFlag(Qt::ControlModifier) && session().meshes()) {
    const double reach = kSnapPixels * view_.camera.pixelAt(at);
    const auto targets = authoring::snapTargets(session().project(), session().meshes()->bones);
    if (const auto snap = authoring::snapEnd(at, targets, reach, s.tissue)) {
      at = snap->at;
      support = snap->support;
    }
  } else if (end >= 0 && session().meshes()) {
    const auto bone = boneUnder(view_.camera.sight(touch.pixel), *session().meshes(),
                                session().project(), session().display());
    if (bone) at = bone->at;
    support = bone ? model::Support{model::Support::On::Bone, bone->bone} : model::Support{};
  }
  std::vector<model::Command> out{model::MovePoint{s.tissue, curve, point, at}};
  if (end >= 0 && support) {
    if (end == 0) {
      out.push_back(model::SetCurveStart{s.tissue, curve, *support});
    } else {
      out.push_back(model::SetCurveEnd{s.tissue, curve, *support});
    }
  }
  return out;
}

void SelectTool::drag(const Touch& touch) {
  if (!held_ || (held_->what.point < 0 && !held_->gizmo)) return;
  if (const model::Tissue* tissue = session().selectedTissue();
      tissue != nullptr && tissue->isProtected)
    return;
  if (!held_->moved && (touch.pixel - held_->pixel).norm() < kSlack) return;
  if (!held_->moved) {
    held_->moved = true;
    Overlay overlay = overlay_;
    overlay.cursor = Qt::ClosedHandCursor;
    show(overlay);
  }
  if (held_->gizmo) {
    session().draft({model::SetAnisotropy{
        held_->what.tissue, held_->gizmo->dragged(held_->part, held_->pixel, touch.pixel)}});
  } else {
    session().draft(moveTo(touch));
  }
}

void SelectTool::release(const Touch& touch) {
  if (!held_) return;
  if (held_->moved)
    session().keepDraft((held_->gizmo ? tr("Spread of %1") : tr("Move a point of %1"))
                            .arg(QString::fromStdString(held_->what.tissue)));
  held_.reset();
  hover(touch);
  Q_EMIT hintChanged();
}

void SelectTool::doubleClick(const Touch& touch) {
  const auto handle = Picker::pickHandle(pickInput(), touch.pixel);
  if (!handle || handle->point >= 0) return;
  session().select(*handle);
  // The place on the curve that is seen nearest to the hand
  const auto place = model::findTissue(session().project(), handle->tissue);
  const mesh::Spline spline = model::splineOf(
      session().project().tissues[*place].curves[static_cast<std::size_t>(handle->curve)]);
  Vector3 best = spline.at(0.0);
  double nearest = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= 200; ++k) {
    const Vector3 p = spline.at(spline.lastParameter() * k / 200.0);
    const auto seen = view_.camera.pixelOf(p);
    if (!seen || (*seen - touch.pixel).norm() >= nearest) continue;
    nearest = (*seen - touch.pixel).norm();
    best = p;
  }
  const Edit edit = insertPoint(session(), best);
  if (session().perform(edit.commands, edit.label)) session().select(edit.select);
}

bool SelectTool::cancel() {
  if (held_) {
    held_.reset();
    session().dropDraft();
    return true;
  }
  if (session().selection() == Selection{}) return false;
  session().select({});
  return true;
}

QString SelectTool::hint() const {
  const Selection& s = session().selection();
  if (held_ && held_->gizmo)
    return held_->part == SpreadPart::Ring
               ? tr("Turns the spread about the curve · Esc gives up")
               : tr("Wider away from the curve, narrower towards it · Esc gives up");
  if (held_ && held_->moved)
    return tr("Let go to keep it · Shift: along the line of sight · Ctrl: snap · Esc gives up");
  if (const model::Tissue* tissue = session().selectedTissue();
      tissue != nullptr && tissue->isProtected)
    return tr("%1 is protected: Ctrl+L lifts that").arg(QString::fromStdString(tissue->name));
  if (s.point >= 0) return tr("Drag the point · Del removes it · Alt+wheel: tissue value");
  if (!s.tissue.empty())
    return tr("%1: drag its points · double-click its curve for a new one · H hides it")
        .arg(QString::fromStdString(s.tissue));
  if (!s.bone.empty())
    return tr("%1 · D draws a muscle from bone to bone").arg(QString::fromStdString(s.bone));
  return tr("Click a muscle, a curve or a bone · D draws a muscle");
}

}  // namespace ecorche::studio
