#include <ecorche/authoring/names.h>
#include <ecorche/studio/edits.h>
#include <ecorche/studio/muscle_panel.h>

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QLocale>
#include <QSignalBlocker>
#include <QSlider>
#include <QSpinBox>
#include <QVBoxLayout>
#include <cmath>
#include <numbers>

namespace ecorche::studio {

namespace {

// Sliders go in equal factors: thrice as thick to the right, a third to the left
constexpr int kTicks = 200;
constexpr double kRange = 4.0;

double factorOf(int tick) { return std::pow(kRange, static_cast<double>(tick) / kTicks); }
int tickOf(double factor) {
  return static_cast<int>(std::lround(kTicks * std::log(factor) / std::log(kRange)));
}

constexpr double kDegrees = 180.0 / std::numbers::pi;

}  // namespace

MusclePanel::MusclePanel(Session& session, QWidget* parent) : QWidget(parent), session_(session) {
  setObjectName("musclePanel");
  auto* layout = new QVBoxLayout(this);
  title_ = new QLabel(this);
  QFont large = title_->font();
  large.setPointSizeF(large.pointSizeF() * 1.25);
  large.setBold(true);
  title_->setFont(large);
  facts_ = new QLabel(this);
  facts_->setWordWrap(true);
  facts_->setForegroundRole(QPalette::PlaceholderText);
  layout->addWidget(title_);
  layout->addWidget(facts_);
  form_ = new QWidget(this);
  auto* form = new QFormLayout(form_);
  form->setContentsMargins(0, 8, 0, 0);
  form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  makeValueRows(*form);
  makeNameRows(*form);
  makeShapeRows(*form);
  layout->addWidget(form_);
  layout->addStretch(1);

  connect(&session_, &Session::projectChanged, this, &MusclePanel::fill);
  connect(&session_, &Session::selectionChanged, this, &MusclePanel::fill);
  connect(&session_, &Session::liveChanged, this, &MusclePanel::fill);
  connect(&session_, &Session::volumesChanged, this, &MusclePanel::fill);
  fill();
}

void MusclePanel::makeValueRows(QFormLayout& form) {
  thicknessSlider_ = new QSlider(Qt::Horizontal, form_);
  thicknessSlider_->setObjectName("thickness");
  thicknessSlider_->setRange(-kTicks, kTicks);
  thicknessSlider_->setToolTip(
      tr("Makes the whole muscle thicker or thinner: all its tissue "
         "values times a factor"));
  form.addRow(tr("Thickness"), thicknessSlider_);
  connect(thicknessSlider_, &QSlider::valueChanged, this, [this](int tick) {
    if (filling_) return;
    if (session_.hasDraft()) session_.dropDraft();
    const Edit edit = thicken(session_, factorOf(tick));
    if (thicknessSlider_->isSliderDown()) {
      session_.draft(edit.commands);
    } else {
      session_.perform(edit.commands, edit.label);
      const QSignalBlocker still(thicknessSlider_);
      thicknessSlider_->setValue(0);
    }
  });
  connect(thicknessSlider_, &QSlider::sliderReleased, this, [this] {
    session_.keepDraft(tr("Thickness of %1").arg(title_->text()));
    const QSignalBlocker still(thicknessSlider_);
    thicknessSlider_->setValue(0);
  });

  volume_ = new QDoubleSpinBox(form_);
  volume_->setObjectName("volume");
  volume_->setRange(0.001, 1e7);
  volume_->setDecimals(1);
  volume_->setSuffix(tr(" cm³"));
  volume_->setKeyboardTracking(false);
  volume_->setToolTip(tr("Scales all values until the muscle has this volume"));
  auto* volumeRow = new QWidget(form_);
  auto* volumeLine = new QHBoxLayout(volumeRow);
  volumeLine->setContentsMargins(0, 0, 0, 0);
  keepVolume_ = new QCheckBox(tr("keep"), volumeRow);
  keepVolume_->setObjectName("keepVolume");
  keepVolume_->setToolTip(tr("The muscle keeps this volume while its points and values change"));
  volumeLine->addWidget(volume_, 1);
  volumeLine->addWidget(keepVolume_);
  form.addRow(tr("Volume"), volumeRow);
  connect(keepVolume_, &QCheckBox::toggled, this, [this](bool on) {
    if (!filling_) session_.keepVolume(session_.selection().tissue, on);
  });
  connect(volume_, &QDoubleSpinBox::valueChanged, this, [this](double cm3) {
    if (!filling_ && !session_.setVolume(session_.selection().tissue, 1e-6 * cm3)) fill();
  });

  valueOf_ = new QLabel(tr("Tissue value"), form_);
  auto* row = new QWidget(form_);
  auto* both = new QHBoxLayout(row);
  both->setContentsMargins(0, 0, 0, 0);
  valueSlider_ = new QSlider(Qt::Horizontal, row);
  valueSlider_->setObjectName("valueSlider");
  valueSlider_->setRange(-kTicks, kTicks);
  value_ = new QDoubleSpinBox(row);
  value_->setObjectName("value");
  value_->setRange(0.001, 1000.0);
  value_->setDecimals(3);
  value_->setSingleStep(0.1);
  value_->setKeyboardTracking(false);
  const QString tip =
      tr("How thick the muscle is at the selected point (all points where none is selected)");
  valueSlider_->setToolTip(tip);
  value_->setToolTip(tip);
  both->addWidget(valueSlider_, 1);
  both->addWidget(value_);
  form.addRow(valueOf_, row);
  connect(valueSlider_, &QSlider::valueChanged, this, [this](int tick) {
    if (!filling_) setValue(factorOf(tick), !valueSlider_->isSliderDown());
  });
  connect(valueSlider_, &QSlider::sliderReleased, this,
          [this] { session_.keepDraft(tr("Tissue value of %1").arg(title_->text())); });
  connect(value_, &QDoubleSpinBox::valueChanged, this, [this](double value) {
    if (!filling_) setValue(value, true);
  });
}

void MusclePanel::makeNameRows(QFormLayout& form) {
  const auto toggle = [&](const char* name, const QString& text, const QString& tip) {
    auto* box = new QCheckBox(text, form_);
    box->setObjectName(name);
    box->setToolTip(tip);
    form.addRow(QString(), box);
    return box;
  };
  protected_ = toggle("protected", tr("Protected"),
                      tr("Its curves and values stay as they are until this is lifted"));
  connect(protected_, &QCheckBox::toggled, this, [this](bool on) {
    if (filling_) return;
    const Edit edit = protectSelected(session_, on);
    session_.perform(edit.commands, edit.label);
  });
  keepsTwin_ = toggle("keepsTwin", tr("Keep its twin in step"),
                      tr("The muscle of the same name on the other side follows every edit"));
  connect(keepsTwin_, &QCheckBox::toggled, this, [this](bool on) {
    if (filling_) return;
    const Edit edit = keepTwinOfSelected(session_, on);
    session_.perform(edit.commands, edit.label);
  });
  side_ = new QComboBox(form_);
  side_->addItem(tr("not said"), static_cast<int>(model::Side::Unknown));
  side_->addItem(tr("left"), static_cast<int>(model::Side::Left));
  side_->addItem(tr("right"), static_cast<int>(model::Side::Right));
  side_->addItem(tr("middle"), static_cast<int>(model::Side::Median));
  form.addRow(tr("Side"), side_);
  connect(side_, &QComboBox::activated, this, [this] {
    session_.perform(model::SetSide{session_.selection().tissue,
                                    static_cast<model::Side>(side_->currentData().toInt())},
                     tr("Side of %1").arg(title_->text()));
  });
  group_ = new QLineEdit(form_);
  group_->setPlaceholderText(tr("e.g. quadriceps"));
  form.addRow(tr("Group"), group_);
  connect(group_, &QLineEdit::editingFinished, this, [this] {
    const model::Tissue* tissue = session_.selectedTissue();
    const std::string text = group_->text().toStdString();
    if (!filling_ && tissue != nullptr && tissue->group != text)
      session_.perform(model::SetGroup{tissue->name, text}, tr("Group of %1").arg(title_->text()));
  });
  layer_ = new QSpinBox(form_);
  layer_->setRange(-1, 99);
  layer_->setSpecialValueText(tr("none"));
  layer_->setKeyboardTracking(false);
  layer_->setToolTip(tr("0 is deepest; layers can be peeled off in the view"));
  form.addRow(tr("Layer"), layer_);
  connect(layer_, &QSpinBox::valueChanged, this, [this](int layer) {
    if (filling_) return;
    session_.perform(model::SetLayer{session_.selection().tissue,
                                     layer < 0 ? std::nullopt : std::optional<std::int64_t>(layer)},
                     tr("Layer of %1").arg(title_->text()));
  });
}

void MusclePanel::makeShapeRows(QFormLayout& form) {
  core_ = new QDoubleSpinBox(form_);
  core_->setRange(0.0, 1000.0);
  core_->setDecimals(2);
  core_->setSuffix(tr(" mm"));
  core_->setSpecialValueText(tr("as the project"));
  core_->setKeyboardTracking(false);
  core_->setToolTip(tr("Radius of the line on which the tissue value is imposed"));
  form.addRow(tr("Core radius"), core_);
  connect(core_, &QDoubleSpinBox::valueChanged, this, [this](double mm) {
    if (filling_) return;
    session_.perform(model::SetTissueCore{session_.selection().tissue,
                                          mm > 0.0 ? std::optional(mm * 1e-3) : std::nullopt},
                     tr("Core of %1").arg(title_->text()));
  });
  const auto spread = [&](const char* name, const QString& tip) {
    auto* box = new QDoubleSpinBox(form_);
    box->setObjectName(name);
    box->setRange(0.01, 100.0);
    box->setSingleStep(0.1);
    box->setKeyboardTracking(false);
    box->setToolTip(tip);
    return box;
  };
  lambda2_ = spread("lambda2", tr("How far the muscle spreads to one side: 1 is round"));
  lambda3_ = spread("lambda3", tr("How far it spreads across that"));
  rotation_ = new QDoubleSpinBox(form_);
  rotation_->setRange(-180.0, 180.0);
  rotation_->setSuffix(tr("°"));
  rotation_->setKeyboardTracking(false);
  rotation_->setToolTip(tr("Turns both about the curve"));
  form.addRow(tr("Spread λ₂"), lambda2_);
  form.addRow(tr("Spread λ₃"), lambda3_);
  form.addRow(tr("Turned by"), rotation_);
  const auto anisotropy = [this] {
    if (filling_) return;
    session_.perform(
        model::SetAnisotropy{session_.selection().tissue,
                             {lambda2_->value(), lambda3_->value(), rotation_->value() / kDegrees}},
        tr("Spread of %1").arg(title_->text()));
  };
  for (QDoubleSpinBox* box : {lambda2_, lambda3_, rotation_})
    connect(box, &QDoubleSpinBox::valueChanged, this, anisotropy);
}

std::vector<model::Command> MusclePanel::valueCommands(double value) const {
  const model::Tissue* tissue = session_.selectedTissue();
  if (tissue == nullptr) return {};
  const Selection& s = session_.selection();
  std::vector<model::Command> out;
  for (std::size_t c = 0; c < tissue->curves.size(); ++c) {
    if (s.curve >= 0 && c != static_cast<std::size_t>(s.curve)) continue;
    for (std::size_t p = 0; p < tissue->curves[c].points.size(); ++p) {
      if (s.point >= 0 && p != static_cast<std::size_t>(s.point)) continue;
      out.push_back(model::SetPointValue{tissue->name, c, p, value});
    }
  }
  return out;
}

void MusclePanel::setValue(double value, bool keep) {
  const auto commands = valueCommands(value);
  if (commands.empty()) return;
  if (keep) {
    session_.perform(commands, tr("Tissue value of %1").arg(title_->text()));
  } else {
    session_.draft(commands);
  }
}

void MusclePanel::fill() {
  const model::Tissue* tissue = session_.selectedTissue();
  form_->setVisible(tissue != nullptr && tissue->hasCurves());
  if (tissue == nullptr) {
    title_->setText(session_.selection().bone.empty()
                        ? tr("Nothing selected")
                        : QString::fromStdString(session_.selection().bone));
    facts_->setText(session_.selection().bone.empty() ? tr("Click a muscle in the view or the list")
                                                      : tr("Bone"));
    return;
  }
  filling_ = true;
  title_->setText(QString::fromStdString(tissue->name));
  QStringList facts;
  if (const auto volume = session_.volumeOf(tissue->name))
    facts << tr("%1 cm³").arg(QLocale().toString(*volume * 1e6, 'f', 1));
  for (const model::Curve& curve : tissue->curves) {
    const auto end = [](const model::Support& s) {
      return s.name.empty() ? tr("free") : QString::fromStdString(s.name);
    };
    facts
        << tr("%1 → %2, %3 points").arg(end(curve.start), end(curve.end)).arg(curve.points.size());
  }
  facts_->setText(facts.join("\n"));

  const auto volume = session_.volumeOf(tissue->name);
  if (!volume_->hasFocus() || !volume) volume_->setValue(1e6 * volume.value_or(0.0));

  const Selection& s = session_.selection();
  double sum = 0.0;
  int count = 0;
  for (std::size_t c = 0; c < tissue->curves.size(); ++c) {
    if (s.curve >= 0 && c != static_cast<std::size_t>(s.curve)) continue;
    for (std::size_t p = 0; p < tissue->curves[c].points.size(); ++p) {
      if (s.point >= 0 && p != static_cast<std::size_t>(s.point)) continue;
      sum += tissue->curves[c].points[p].tissue;
      ++count;
    }
  }
  const double value = count > 0 ? sum / count : 1.0;
  value_->setValue(value);
  if (!valueSlider_->isSliderDown()) valueSlider_->setValue(tickOf(value));
  valueOf_->setText(s.point >= 0 ? tr("Value, point %1").arg(s.point + 1)
                                 : tr("Value, all points"));
  keepVolume_->setEnabled(volume.has_value());
  keepVolume_->setChecked(session_.keepsVolume(tissue->name));
  protected_->setChecked(tissue->isProtected);
  keepsTwin_->setChecked(tissue->keepsTwin);
  keepsTwin_->setEnabled(!tissue->isProtected && authoring::mirroredName(tissue->name).has_value());
  for (QWidget* part : std::initializer_list<QWidget*>{
           thicknessSlider_, volume_, valueSlider_, value_, core_, lambda2_, lambda3_, rotation_})
    part->setEnabled(!tissue->isProtected && (part != volume_ || volume));
  side_->setCurrentIndex(side_->findData(static_cast<int>(tissue->side)));
  if (!group_->hasFocus()) group_->setText(QString::fromStdString(tissue->group));
  layer_->setValue(tissue->layer.value_or(-1));
  core_->setValue(1e3 * tissue->coreRadius.value_or(0.0));
  lambda2_->setValue(tissue->anisotropy.lambda2);
  lambda3_->setValue(tissue->anisotropy.lambda3);
  rotation_->setValue(tissue->anisotropy.rotation * kDegrees);
  filling_ = false;
}

}  // namespace ecorche::studio
