#include <ecorche/studio/tool.h>

namespace ecorche::studio {

Picker::Input Tool::pickInput() const {
  const Session& s = view_.session;
  return {s.project(), view_.camera, s.meshes(), s.tissues(), s.display(), s.selection()};
}

void Tool::show(const Overlay& overlay) {
  overlay_ = overlay;
  Q_EMIT overlayChanged();
  Q_EMIT hintChanged();
}

}  // namespace ecorche::studio
