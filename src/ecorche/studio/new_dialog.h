#pragma once

#include <ecorche/authoring/new_project.h>

#include <QDialog>
#include <QStringList>

class QComboBox;
class QDoubleSpinBox;
class QDialogButtonBox;
class QLabel;
class QLineEdit;

namespace ecorche::studio {

/// Asks for what a new project is made of: skin, bones, unit, symmetry, and where it goes.
class NewDialog : public QDialog {
  Q_OBJECT

 public:
  explicit NewDialog(QWidget* parent = nullptr);

  /// Files that were dropped: the one whose name speaks of skin or body is the skin, a folder and
  /// all others are bones.
  void take(const QStringList& files);
  [[nodiscard]] authoring::NewProjectRequest request() const;

 private:
  QLineEdit* skin_;
  QLineEdit* bones_;
  QLineEdit* target_;
  QComboBox* unit_;
  QComboBox* symmetry_;
  QLabel* trouble_;
  QDialogButtonBox* buttons_;
  bool targetChosen_ = false;

  void browse(QLineEdit* line, bool many);
  void look();
};

}  // namespace ecorche::studio
