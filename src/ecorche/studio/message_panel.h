#pragma once

#include <ecorche/studio/session.h>

#include <QListWidget>

namespace ecorche::studio {

/// What the program had to say, newest first; a click flies to the place.
class MessagePanel : public QListWidget {
  Q_OBJECT

 public:
  explicit MessagePanel(Session& session, QWidget* parent = nullptr);

 signals:
  void flyTo(const Eigen::Vector3d& place);

 private:
  void add(Severity severity, const QString& text, const std::optional<Eigen::Vector3d>& place);
};

}  // namespace ecorche::studio
