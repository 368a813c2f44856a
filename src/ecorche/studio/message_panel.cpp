#include <ecorche/studio/message_panel.h>

#include <QVariant>

namespace ecorche::studio {

namespace {

constexpr int kPlaceRole = Qt::UserRole;
constexpr int kMost = 200;

}  // namespace

MessagePanel::MessagePanel(Session& session, QWidget* parent) : QListWidget(parent) {
  setObjectName("messages");
  setAccessibleName(tr("Messages"));
  setWordWrap(true);
  setAlternatingRowColors(true);
  connect(&session, &Session::told, this, &MessagePanel::add);
  connect(this, &QListWidget::itemClicked, this, [this](QListWidgetItem* item) {
    const QVariantList p = item->data(kPlaceRole).toList();
    if (p.size() == 3) Q_EMIT flyTo({p[0].toDouble(), p[1].toDouble(), p[2].toDouble()});
  });
}

void MessagePanel::add(Severity severity, const QString& text,
                       const std::optional<Eigen::Vector3d>& place) {
  auto* item = new QListWidgetItem(text);
  if (severity == Severity::Error) item->setForeground(QColor(226, 96, 84));
  if (severity == Severity::Warning) item->setForeground(QColor(214, 158, 46));
  if (place) {
    item->setData(kPlaceRole, QVariantList{place->x(), place->y(), place->z()});
    item->setToolTip(tr("Click to fly there"));
  }
  insertItem(0, item);
  while (count() > kMost) delete takeItem(count() - 1);
}

}  // namespace ecorche::studio
