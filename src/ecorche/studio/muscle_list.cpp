#include <ecorche/studio/muscle_list.h>
#include <ecorche/studio/theme.h>

#include <QColorDialog>
#include <QHeaderView>
#include <QLocale>
#include <QMenu>
#include <QPainter>

namespace ecorche::studio {

namespace {

constexpr int kNameRole = Qt::UserRole;

QIcon swatch(const QColor& colour) {
  QPixmap pixmap(16, 16);
  pixmap.fill(Qt::transparent);
  QPainter p(&pixmap);
  p.setRenderHint(QPainter::Antialiasing);
  p.setPen(Qt::NoPen);
  p.setBrush(colour);
  p.drawRoundedRect(QRectF(1.5, 1.5, 13, 13), 3, 3);
  return QIcon(pixmap);
}

}  // namespace

MuscleList::MuscleList(Session& session, std::function<QColor(std::size_t)> colourOf,
                       QWidget* parent)
    : QTreeWidget(parent), session_(session), colourOf_(std::move(colourOf)) {
  setObjectName("muscleList");
  setAccessibleName(tr("Muscles"));
  setHeaderLabels({QString(), tr("Muscle"), tr("cm³")});
  setRootIsDecorated(false);
  setUniformRowHeights(true);
  setContextMenuPolicy(Qt::CustomContextMenu);
  header()->setStretchLastSection(false);
  header()->setSectionResizeMode(kName, QHeaderView::Stretch);
  header()->setSectionResizeMode(kEye, QHeaderView::Fixed);
  header()->setSectionResizeMode(kVolume, QHeaderView::ResizeToContents);
  header()->resizeSection(kEye, 30);
  setIconSize({16, 16});
  headerItem()->setTextAlignment(kVolume, Qt::AlignRight);

  connect(&session_, &Session::projectChanged, this, &MuscleList::fill);
  connect(&session_, &Session::liveChanged, this, &MuscleList::fill);
  connect(&session_, &Session::volumesChanged, this, &MuscleList::fill);
  connect(&session_, &Session::displayChanged, this, &MuscleList::fill);
  connect(&session_, &Session::selectionChanged, this, &MuscleList::showSelection);
  connect(this, &QTreeWidget::itemChanged, this, &MuscleList::edited);
  connect(this, &QTreeWidget::itemClicked, this, &MuscleList::clicked);
  connect(this, &QTreeWidget::customContextMenuRequested, this, &MuscleList::menu);
  fill();
}

void MuscleList::fill() {
  if (filling_ || state() == EditingState) return;
  filling_ = true;
  const auto& tissues = session_.project().tissues;
  while (topLevelItemCount() > static_cast<int>(tissues.size()))
    delete takeTopLevelItem(topLevelItemCount() - 1);
  while (topLevelItemCount() < static_cast<int>(tissues.size())) {
    auto* item = new QTreeWidgetItem;
    item->setFlags(item->flags() | Qt::ItemIsEditable);
    item->setTextAlignment(kVolume, Qt::AlignRight | Qt::AlignVCenter);
    addTopLevelItem(item);
  }
  for (std::size_t t = 0; t < tissues.size(); ++t) {
    QTreeWidgetItem* item = topLevelItem(static_cast<int>(t));
    const QString name = QString::fromStdString(tissues[t].name);
    const bool shown = session_.display().showsTissue(tissues[t].name);
    item->setData(kEye, kNameRole, name);
    item->setText(kName, name);
    item->setIcon(kName, swatch(colourOf_(t)));
    item->setIcon(kEye, icon(shown ? Glyph::Eye : Glyph::EyeClosed,
                             palette().color(shown ? QPalette::Text : QPalette::PlaceholderText)));
    item->setToolTip(kEye, shown ? tr("Hide") : tr("Show"));
    item->setForeground(kName, palette().color(shown ? QPalette::Text : QPalette::PlaceholderText));
    const auto volume = session_.volumeOf(tissues[t].name);
    item->setText(kVolume, volume ? QLocale().toString(*volume * 1e6, 'f', 1) : QString("–"));
    const bool filler = tissues[t].kind != model::Tissue::Kind::Muscle;
    item->setToolTip(kName, filler
                                ? QString::fromStdString(std::string(model::word(tissues[t].kind)))
                                : tr("Double-click to rename"));
  }
  filling_ = false;
  showSelection();
}

void MuscleList::showSelection() {
  filling_ = true;
  clearSelection();
  for (int i = 0; i < topLevelItemCount(); ++i) {
    QTreeWidgetItem* item = topLevelItem(i);
    const bool is =
        item->data(kEye, kNameRole).toString().toStdString() == session_.selection().tissue;
    item->setSelected(is);
    if (is) setCurrentItem(item, kName);
  }
  filling_ = false;
}

void MuscleList::edited(QTreeWidgetItem* item, int column) {
  if (filling_ || column != kName) return;
  const std::string old = item->data(kEye, kNameRole).toString().toStdString();
  const std::string name = item->text(kName).trimmed().toStdString();
  if (name == old) return;
  const bool selected = session_.selection().tissue == old;
  if (session_.perform(model::RenameTissue{old, name},
                       tr("Rename %1").arg(QString::fromStdString(old))) &&
      selected)
    session_.select({name, -1, -1, {}});
  QMetaObject::invokeMethod(this, &MuscleList::fill, Qt::QueuedConnection);
}

void MuscleList::clicked(QTreeWidgetItem* item, int column) {
  const std::string name = item->data(kEye, kNameRole).toString().toStdString();
  if (column == kEye) {
    session_.setHidden(name, session_.display().showsTissue(name));
  } else {
    session_.select({name, -1, -1, {}});
  }
}

void MuscleList::menu(const QPoint& at) {
  QTreeWidgetItem* item = itemAt(at);
  if (item == nullptr) return;
  clicked(item, kName);
  const std::string name = session_.selection().tissue;
  QMenu menu(this);
  menu.addAction(tr("Rename"), this, [this, item] { editItem(item, kName); });
  menu.addAction(tr("Colour …"), this, [this, name] {
    const auto place = model::findTissue(session_.project(), name);
    if (!place) return;
    const QColor chosen = QColorDialog::getColor(colourOf_(*place), this, tr("Colour"));
    if (!chosen.isValid()) return;
    const model::Colour colour{static_cast<std::uint8_t>(chosen.red()),
                               static_cast<std::uint8_t>(chosen.green()),
                               static_cast<std::uint8_t>(chosen.blue())};
    session_.perform(model::SetColour{name, colour},
                     tr("Colour of %1").arg(QString::fromStdString(name)));
  });
  menu.addSeparator();
  menu.addAction(tr("Duplicate"), this, &MuscleList::duplicateAsked);
  menu.addAction(tr("Mirror"), this, &MuscleList::mirrorAsked);
  menu.addAction(tr("Delete"), this, &MuscleList::deleteAsked);
  menu.addSeparator();
  const bool solo = session_.display().solo == name;
  menu.addAction(solo ? tr("Show the others again") : tr("Show this one alone"), this,
                 [this, name, solo] {
                   Display display = session_.display();
                   display.solo = solo ? std::nullopt : std::optional(name);
                   session_.setDisplay(display);
                 });
  menu.exec(viewport()->mapToGlobal(at));
}

}  // namespace ecorche::studio
