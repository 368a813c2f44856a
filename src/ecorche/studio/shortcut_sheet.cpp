#include <ecorche/studio/shortcut_sheet.h>

#include <QGridLayout>
#include <QLabel>
#include <QVBoxLayout>

namespace ecorche::studio {

ShortcutSheet::ShortcutSheet(const QList<QAction*>& actions, NavigationPreset navigation,
                             QWidget* parent)
    : QDialog(parent) {
  setObjectName("shortcutSheet");
  setWindowTitle(tr("Keys and hands"));
  auto* layout = new QVBoxLayout(this);
  auto* hands = new QLabel(navigationHelp(navigation), this);
  hands->setWordWrap(true);
  layout->addWidget(hands);
  auto* grid = new QGridLayout;
  grid->setHorizontalSpacing(18);
  layout->addLayout(grid);
  QList<QAction*> keyed;
  for (QAction* action : actions) {
    if (!action->shortcut().isEmpty()) keyed << action;
  }
  const int rows = (static_cast<int>(keyed.size()) + 1) / 2;
  for (int i = 0; i < keyed.size(); ++i) {
    auto* key = new QLabel(keyed[i]->shortcut().toString(QKeySequence::NativeText), this);
    QFont bold = key->font();
    bold.setBold(true);
    key->setFont(bold);
    grid->addWidget(key, i % rows, 2 * (i / rows), Qt::AlignRight);
    grid->addWidget(new QLabel(keyed[i]->text().remove('&').remove("…"), this), i % rows,
                    2 * (i / rows) + 1);
  }
}

}  // namespace ecorche::studio
