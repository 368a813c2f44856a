#include <ecorche/studio/click_tool.h>

namespace ecorche::studio {

using mesh::Vector3;

std::optional<CurveTip> ClickTool::tipAt(const Eigen::Vector2d& pixel) const {
  if (!session().meshes()) return std::nullopt;
  const auto bone = boneUnder(view_.camera.sight(pixel), *session().meshes(), session().project(),
                              session().display());
  if (!bone) return std::nullopt;
  return CurveTip{{model::Support::On::Bone, bone->bone}, bone->at};
}

std::vector<authoring::SightRay> ClickTool::sightsTo(const Eigen::Vector2d& pixel) const {
  std::vector<authoring::SightRay> out;
  for (const auto& p : pixels_) out.push_back(view_.camera.sight(p));
  out.push_back(view_.camera.sight(pixel));
  return out;
}

void ClickTool::showPath(const Touch& touch, const std::optional<CurveTip>& tip) {
  over_ = tip ? QString::fromStdString(tip->support.name) : QString();
  Overlay overlay;
  if (from_) {
    overlay.marks.push_back(from_->at);
    overlay.stroke = shownPath(sightsTo(touch.pixel), from_->at,
                               tip ? tip->at : view_.camera.placeLike(from_->at, touch.pixel));
  }
  if (tip) {
    overlay.marks.push_back(tip->at);
    overlay.hovered.bone = tip->support.name;
  }
  overlay.cursor = tip || from_ ? Qt::CrossCursor : Qt::ForbiddenCursor;
  show(overlay);
}

void ClickTool::hover(const Touch& touch) { showPath(touch, tipAt(touch.pixel)); }

bool ClickTool::press(const Touch& touch) {
  const auto tip = tipAt(touch.pixel);
  if (!from_) {
    if (!tip) return false;
    from_ = tip;
    pixels_.assign(1, touch.pixel);
  } else if (tip && !touch.modifiers.testFlag(Qt::ShiftModifier) &&
             (touch.pixel - pixels_.back()).norm() > 2.0) {
    const DrawnMuscle drawn =
        drawnMuscle(session(), *from_, *tip, sightsTo(touch.pixel), {}, std::nullopt);
    from_.reset();
    pixels_.clear();
    perform(session(), drawn, tr("Draw %1").arg(QString::fromStdString(drawn.name)));
  } else {
    pixels_.push_back(touch.pixel);
  }
  showPath(touch, tip);
  return true;
}

bool ClickTool::cancel() {
  if (!from_) return false;
  from_.reset();
  pixels_.clear();
  show({});
  return true;
}

QString ClickTool::hint() const {
  if (!session().meshes()) return tr("Reading the meshes …");
  if (!from_)
    return over_.isEmpty() ? tr("Click the bone where the muscle begins")
                           : tr("Click to begin on %1").arg(over_);
  return over_.isEmpty() ? tr("Click places to pass, then the bone where it ends · Esc gives up")
                         : tr("Click to end on %1 · Shift+click to pass here").arg(over_);
}

}  // namespace ecorche::studio
