#pragma once

#include <ecorche/studio/session.h>

#include <QTreeWidget>
#include <functional>

namespace ecorche::studio {

/// Every tissue of the project: eye, colour, name, volume. Names are edited in place, the eye
/// hides.
class MuscleList : public QTreeWidget {
  Q_OBJECT

 public:
  /// @param colourOf  of a tissue by its place in the project, as the view has it
  MuscleList(Session& session, std::function<QColor(std::size_t)> colourOf,
             QWidget* parent = nullptr);

 signals:
  void deleteAsked();
  void duplicateAsked();
  void mirrorAsked();

 private:
  enum Column { kEye, kName, kVolume };
  Session& session_;
  std::function<QColor(std::size_t)> colourOf_;
  bool filling_ = false;

  void fill();
  void showSelection();
  void edited(QTreeWidgetItem* item, int column);
  void clicked(QTreeWidgetItem* item, int column);
  void menu(const QPoint& at);
};

}  // namespace ecorche::studio
