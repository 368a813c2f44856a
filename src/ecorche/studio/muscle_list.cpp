#include <ecorche/studio/edits.h>
#include <ecorche/studio/muscle_list.h>
#include <ecorche/studio/theme.h>

#include <QColorDialog>
#include <QHeaderView>
#include <QLocale>
#include <QMenu>
#include <QPainter>
#include <algorithm>
#include <set>

namespace ecorche::studio {

namespace {

constexpr int kNameRole = Qt::UserRole;
constexpr int kGroupRole = Qt::UserRole + 1;

QIcon swatch(const QColor& colour) {
  QPixmap pixmap(16, 16);
  pixmap.fill(Qt::transparent);
  QPainter p(&pixmap);
  p.setRenderHint(QPainter::Antialiasing);
  // To be seen on a selected row, too, whatever its colour
  p.setPen(QPen(QColor(255, 255, 255, 90), 1.0));
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
  setIndentation(14);
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

// Muscles of a group stand together, where its first one stands in the project.
std::vector<MuscleList::Row> MuscleList::rows() const {
  const auto& tissues = session_.project().tissues;
  std::vector<Row> out;
  for (std::size_t t = 0; t < tissues.size(); ++t) {
    const std::string& group = tissues[t].group;
    auto row = group.empty() ? out.end() : std::ranges::find(out, group, &Row::group);
    if (row == out.end()) row = out.insert(out.end(), Row{group, {}});
    row->tissues.push_back(t);
  }
  return out;
}

// New items only where names or groups changed: what is open stays open, what is edited is kept.
void MuscleList::layOut(const std::vector<Row>& rows) {
  std::vector<std::string> wanted;
  for (const Row& row : rows) {
    wanted.push_back("group " + row.group);
    for (const std::size_t t : row.tissues) wanted.push_back(session_.project().tissues[t].name);
  }
  if (wanted == laidOut_) return;
  laidOut_ = std::move(wanted);
  std::set<std::string> closed;
  for (int i = 0; i < topLevelItemCount(); ++i) {
    if (topLevelItem(i)->childCount() > 0 && !topLevelItem(i)->isExpanded())
      closed.insert(topLevelItem(i)->data(kEye, kGroupRole).toString().toStdString());
  }
  clear();
  itemOf_.clear();
  for (const Row& row : rows) {
    QTreeWidgetItem* parent = invisibleRootItem();
    if (!row.group.empty()) {
      parent = new QTreeWidgetItem(this);
      parent->setData(kEye, kGroupRole, QString::fromStdString(row.group));
      parent->setText(kName, QString::fromStdString(row.group));
      QFont bold = font();
      bold.setBold(true);
      parent->setFont(kName, bold);
      parent->setExpanded(!closed.contains(row.group));
    }
    for (const std::size_t t : row.tissues) {
      auto* item = new QTreeWidgetItem(parent);
      item->setFlags(item->flags() | Qt::ItemIsEditable);
      itemOf_[session_.project().tissues[t].name] = item;
    }
  }
  setRootIsDecorated(std::ranges::any_of(rows, [](const Row& row) { return !row.group.empty(); }));
}

void MuscleList::showEye(QTreeWidgetItem& item, bool shown) const {
  const QColor colour = palette().color(shown ? QPalette::Text : QPalette::PlaceholderText);
  item.setIcon(kEye, icon(shown ? Glyph::Eye : Glyph::EyeClosed, colour));
  item.setToolTip(kEye, shown ? tr("Hide") : tr("Show"));
  item.setForeground(kName, colour);
}

void MuscleList::fill() {
  if (filling_ || state() == EditingState) return;
  filling_ = true;
  const auto& tissues = session_.project().tissues;
  const std::vector<Row> all = rows();
  layOut(all);
  const auto cm3 = [](double volume) { return QLocale().toString(volume * 1e6, 'f', 1); };
  for (const Row& row : all) {
    double sum = 0.0;
    bool anyShown = false;
    bool anyVolume = false;
    for (const std::size_t t : row.tissues) {
      const model::Tissue& tissue = tissues[t];
      QTreeWidgetItem& item = *itemOf_.at(tissue.name);
      const QString name = QString::fromStdString(tissue.name);
      const bool shown = session_.display().showsTissue(tissue.name);
      anyShown = anyShown || shown;
      item.setData(kEye, kNameRole, name);
      item.setText(kName, name);
      item.setIcon(kName, swatch(colourOf_(t)));
      showEye(item, shown);
      const auto volume = session_.volumeOf(tissue.name);
      sum += volume.value_or(0.0);
      anyVolume = anyVolume || volume;
      item.setText(kVolume, volume ? cm3(*volume) : QString("–"));
      item.setTextAlignment(kVolume, Qt::AlignRight | Qt::AlignVCenter);
      item.setIcon(kVolume, tissue.isProtected
                                ? icon(Glyph::Lock, palette().color(QPalette::PlaceholderText))
                                : QIcon());
      item.setToolTip(kVolume, tissue.isProtected ? tr("Protected") : QString());
      item.setToolTip(kName, tissue.kind == model::Tissue::Kind::Muscle
                                 ? tr("Double-click to rename")
                                 : QString::fromStdString(std::string(model::word(tissue.kind))));
    }
    if (row.group.empty()) continue;
    QTreeWidgetItem& parent = *itemOf_.at(tissues[row.tissues.front()].name)->parent();
    showEye(parent, anyShown);
    parent.setText(kVolume, anyVolume ? cm3(sum) : QString("–"));
    parent.setTextAlignment(kVolume, Qt::AlignRight | Qt::AlignVCenter);
  }
  filling_ = false;
  showSelection();
}

void MuscleList::showSelection() {
  filling_ = true;
  clearSelection();
  const auto item = itemOf_.find(session_.selection().tissue);
  if (item != itemOf_.end()) {
    item->second->setSelected(true);
    setCurrentItem(item->second, kName);
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
  const QString group = item->data(kEye, kGroupRole).toString();
  if (!group.isEmpty()) {
    if (column == kEye) showGroup(*item);
    return;
  }
  const std::string name = item->data(kEye, kNameRole).toString().toStdString();
  if (column == kEye) {
    session_.setHidden(name, session_.display().showsTissue(name));
  } else {
    session_.select({name, -1, -1, {}});
  }
}

// All of it hidden if any of it is to be seen, else all of it shown.
void MuscleList::showGroup(const QTreeWidgetItem& group) {
  Display display = session_.display();
  std::vector<std::string> names;
  for (int i = 0; i < group.childCount(); ++i)
    names.push_back(group.child(i)->data(kEye, kNameRole).toString().toStdString());
  const bool any = std::ranges::any_of(
      names, [&](const std::string& name) { return display.showsTissue(name); });
  for (const std::string& name : names) {
    if (any) {
      display.hidden.insert(name);
    } else {
      display.hidden.erase(name);
    }
  }
  session_.setDisplay(display);
}

void MuscleList::menu(const QPoint& at) {
  QTreeWidgetItem* item = itemAt(at);
  if (item == nullptr || !item->data(kEye, kGroupRole).toString().isEmpty()) return;
  clicked(item, kName);
  const std::string name = session_.selection().tissue;
  const model::Tissue* tissue = session_.selectedTissue();
  if (tissue == nullptr) return;
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
  const auto toggle = [&](const QString& text, bool on, Edit (*edit)(const Session&, bool)) {
    QAction* action = menu.addAction(text, this, [this, on, edit] {
      const Edit made = edit(session_, !on);
      session_.perform(made.commands, made.label);
    });
    action->setCheckable(true);
    action->setChecked(on);
  };
  toggle(tr("Protected"), tissue->isProtected, protectSelected);
  if (tissue->hasCurves())
    toggle(tr("Keep its twin in step"), tissue->keepsTwin, keepTwinOfSelected);
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
