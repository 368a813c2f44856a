#pragma once

#include <ecorche/studio/session.h>

#include <QWidget>

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QFormLayout;
class QLabel;
class QLineEdit;
class QSlider;
class QSpinBox;

namespace ecorche::studio {

/// What can be said about the selected muscle in words and numbers: value of the selected point,
/// thickness of the whole, side, group, layer, core radius, anisotropy.
class MusclePanel : public QWidget {
  Q_OBJECT

 public:
  explicit MusclePanel(Session& session, QWidget* parent = nullptr);

 private:
  Session& session_;
  bool filling_ = false;

  QLabel* title_;
  QLabel* facts_;
  QWidget* form_;
  QSlider* thicknessSlider_;
  QDoubleSpinBox* volume_;
  QCheckBox* keepVolume_;
  QSlider* valueSlider_;
  QDoubleSpinBox* value_;
  QLabel* valueOf_;
  QCheckBox* protected_;
  QCheckBox* keepsTwin_;
  QComboBox* side_;
  QLineEdit* group_;
  QSpinBox* layer_;
  QDoubleSpinBox* core_;
  QDoubleSpinBox* lambda2_;
  QDoubleSpinBox* lambda3_;
  QDoubleSpinBox* rotation_;

  void makeValueRows(QFormLayout& form);
  void makeNameRows(QFormLayout& form);
  void makeShapeRows(QFormLayout& form);
  void fill();
  void setValue(double value, bool keep);
  [[nodiscard]] std::vector<model::Command> valueCommands(double value) const;
};

}  // namespace ecorche::studio
