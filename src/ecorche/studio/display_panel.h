#pragma once

#include <ecorche/studio/session.h>

#include <QWidget>

class QCheckBox;
class QComboBox;
class QSlider;
class QSpinBox;

namespace ecorche::studio {

/// What is seen: skin and its opacity, bones, muscles, curves, a plane that cuts, colours; and the
/// project's fat, which is what one sees muscles through.
class DisplayPanel : public QWidget {
  Q_OBJECT

 public:
  explicit DisplayPanel(Session& session, QWidget* parent = nullptr);

 private:
  Session& session_;
  bool filling_ = false;
  QSlider* opacity_;
  QCheckBox* bones_;
  QCheckBox* muscles_;
  QCheckBox* fibers_;
  QCheckBox* curves_;
  QCheckBox* fine_;
  QComboBox* clipAxis_;
  QSlider* clipAt_;
  QCheckBox* clipFlip_;
  QSpinBox* peel_;
  QSlider* explode_;
  QComboBox* palette_;
  QSlider* fat_;

  void fill();
  void changed();
};

}  // namespace ecorche::studio
