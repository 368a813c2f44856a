#pragma once

#include <ecorche/studio/session.h>

#include <QTreeWidget>
#include <functional>
#include <map>
#include <string>
#include <vector>

namespace ecorche::studio {

/// Every tissue of the project: eye, colour, name, volume, a lock where it is protected; groups as
/// branches. Names are edited in place, the eye hides.
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

  // What stands together: a group's tissues, or one or more that have none
  struct Row {
    std::string group;
    std::vector<std::size_t> tissues;  // by place in the project
  };
  std::vector<std::string> laidOut_;
  std::map<std::string, QTreeWidgetItem*> itemOf_;

  void fill();
  [[nodiscard]] std::vector<Row> rows() const;
  void layOut(const std::vector<Row>& rows);
  void showEye(QTreeWidgetItem& item, bool shown) const;
  void showGroup(const QTreeWidgetItem& group);
  void showSelection();
  void edited(QTreeWidgetItem* item, int column);
  void clicked(QTreeWidgetItem* item, int column);
  void menu(const QPoint& at);
};

}  // namespace ecorche::studio
