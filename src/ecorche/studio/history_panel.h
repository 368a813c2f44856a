#pragma once

#include <ecorche/studio/session.h>

#include <QListWidget>

namespace ecorche::studio {

/// What was done, and what was undone and can come back; a click goes there.
class HistoryPanel : public QListWidget {
  Q_OBJECT

 public:
  explicit HistoryPanel(Session& session, QWidget* parent = nullptr);

 private:
  Session& session_;
  void fill();
};

}  // namespace ecorche::studio
