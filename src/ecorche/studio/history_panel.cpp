#include <ecorche/studio/history_panel.h>

#include <QSignalBlocker>

namespace ecorche::studio {

HistoryPanel::HistoryPanel(Session& session, QWidget* parent)
    : QListWidget(parent), session_(session) {
  setObjectName("history");
  setAccessibleName(tr("History"));
  connect(&session_, &Session::projectChanged, this, &HistoryPanel::fill);
  connect(this, &QListWidget::itemClicked, this, [this](QListWidgetItem* item) {
    session_.goToStep(static_cast<std::size_t>(row(item)));
  });
  fill();
}

void HistoryPanel::fill() {
  const QSignalBlocker still(this);
  const auto& steps = session_.history().steps();
  const std::size_t done = session_.history().stepsDone();
  clear();
  addItem(tr("Start"));
  for (std::size_t k = 0; k < steps.size(); ++k) {
    addItem(QString::fromStdString(steps[k].label));
    if (k >= done) item(count() - 1)->setForeground(palette().placeholderText());
  }
  setCurrentRow(static_cast<int>(done));
}

}  // namespace ecorche::studio
