#pragma once

#include <ecorche/studio/navigation.h>

#include <QAction>
#include <QDialog>
#include <QList>

namespace ecorche::studio {

/// Every key on one page, made from the actions themselves so that it cannot be wrong.
class ShortcutSheet : public QDialog {
  Q_OBJECT

 public:
  ShortcutSheet(const QList<QAction*>& actions, NavigationPreset navigation, QWidget* parent);
};

}  // namespace ecorche::studio
