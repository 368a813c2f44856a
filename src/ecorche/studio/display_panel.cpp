#include <ecorche/studio/display_panel.h>

#include <QCheckBox>
#include <QComboBox>
#include <QFormLayout>
#include <QSlider>
#include <QSpinBox>

namespace ecorche::studio {

namespace {

constexpr int kTicks = 1000;
constexpr double kMostFat = 1.0;  // of the slider; a number may be larger in the file

QSlider* slider(QWidget* parent, const char* name) {
  auto* out = new QSlider(Qt::Horizontal, parent);
  out->setObjectName(name);
  out->setRange(0, kTicks);
  return out;
}

}  // namespace

DisplayPanel::DisplayPanel(Session& session, QWidget* parent) : QWidget(parent), session_(session) {
  setObjectName("displayPanel");
  auto* form = new QFormLayout(this);
  opacity_ = slider(this, "skinOpacity");
  form->addRow(tr("Skin"), opacity_);
  bones_ = new QCheckBox(tr("Bones"), this);
  muscles_ = new QCheckBox(tr("Muscles"), this);
  fibers_ = new QCheckBox(tr("Fibres on muscles"), this);
  fibers_->setObjectName("fibers");
  fibers_->setToolTip(tr("Streaks along the muscles' curves"));
  curves_ = new QCheckBox(tr("Curves of all muscles"), this);
  form->addRow(QString(), bones_);
  form->addRow(QString(), muscles_);
  form->addRow(QString(), fibers_);
  form->addRow(QString(), curves_);
  peel_ = new QSpinBox(this);
  peel_->setRange(-1, 99);
  peel_->setSpecialValueText(tr("all layers"));
  peel_->setToolTip(tr("Hides muscles of higher layers"));
  form->addRow(tr("Peel down to"), peel_);

  explode_ = slider(this, "explode");
  explode_->setToolTip(tr("Draws muscles apart, away from the middle of the body"));
  form->addRow(tr("Explode"), explode_);

  clipAxis_ = new QComboBox(this);
  clipAxis_->setObjectName("clipAxis");
  clipAxis_->addItems({tr("none"), tr("across X"), tr("across Y"), tr("across Z")});
  clipAt_ = slider(this, "clipAt");
  clipAt_->setValue(kTicks / 2);
  clipFlip_ = new QCheckBox(tr("Keep the other half"), this);
  form->addRow(tr("Cut"), clipAxis_);
  form->addRow(QString(), clipAt_);
  form->addRow(QString(), clipFlip_);

  palette_ = new QComboBox(this);
  palette_->addItems({tr("flesh"), tr("distinct")});
  palette_->setToolTip(tr("Both can be told apart by colour-blind eyes"));
  form->addRow(tr("Colours"), palette_);
  fine_ = new QCheckBox(tr("Soft light at rest"), this);
  form->addRow(QString(), fine_);
  fat_ = slider(this, "fat");
  fat_->setToolTip(
      tr("How much of the space under the skin is fat: part of the model, not only of "
         "the view"));
  form->addRow(tr("Fat"), fat_);

  for (QSlider* s : {opacity_, clipAt_, explode_})
    connect(s, &QSlider::valueChanged, this, &DisplayPanel::changed);
  for (QCheckBox* box : {bones_, muscles_, fibers_, curves_, fine_, clipFlip_})
    connect(box, &QCheckBox::toggled, this, &DisplayPanel::changed);
  for (QComboBox* box : {clipAxis_, palette_})
    connect(box, &QComboBox::currentIndexChanged, this, &DisplayPanel::changed);
  connect(peel_, &QSpinBox::valueChanged, this, &DisplayPanel::changed);
  connect(fat_, &QSlider::valueChanged, this, [this](int tick) {
    if (filling_) return;
    const model::Command command = model::SetFat{kMostFat * tick / kTicks};
    if (fat_->isSliderDown()) {
      session_.draft({command});
    } else {
      session_.perform(command, tr("Fat"));
    }
  });
  connect(fat_, &QSlider::sliderReleased, this, [this] { session_.keepDraft(tr("Fat")); });
  connect(&session_, &Session::displayChanged, this, &DisplayPanel::fill);
  connect(&session_, &Session::projectChanged, this, &DisplayPanel::fill);
  fill();
}

void DisplayPanel::fill() {
  const Display& d = session_.display();
  filling_ = true;
  opacity_->setValue(static_cast<int>(kTicks * (d.skin ? d.skinOpacity : 0.0)));
  bones_->setChecked(d.bones);
  muscles_->setChecked(d.muscles);
  fibers_->setChecked(d.fibers);
  curves_->setChecked(d.allCurves);
  fine_->setChecked(d.fine);
  explode_->setValue(static_cast<int>(kTicks * d.explode));
  peel_->setValue(d.peelAbove.value_or(-1));
  palette_->setCurrentIndex(d.palette == render::Palette::Anatomical ? 0 : 1);
  if (!d.clip) clipAxis_->setCurrentIndex(0);
  clipAt_->setEnabled(d.clip.has_value());
  clipFlip_->setEnabled(d.clip.has_value());
  if (!fat_->isSliderDown())
    fat_->setValue(static_cast<int>(kTicks * session_.project().settings.fat / kMostFat));
  filling_ = false;
}

void DisplayPanel::changed() {
  if (filling_) return;
  Display d = session_.display();
  d.skinOpacity = static_cast<double>(opacity_->value()) / kTicks;
  d.skin = d.skinOpacity > 0.0;
  d.bones = bones_->isChecked();
  d.muscles = muscles_->isChecked();
  d.fibers = fibers_->isChecked();
  d.allCurves = curves_->isChecked();
  d.fine = fine_->isChecked();
  d.explode = static_cast<double>(explode_->value()) / kTicks;
  d.peelAbove = peel_->value() < 0 ? std::nullopt : std::optional(peel_->value());
  d.palette =
      palette_->currentIndex() == 0 ? render::Palette::Anatomical : render::Palette::Distinct;
  d.clip.reset();
  const int axis = clipAxis_->currentIndex() - 1;
  if (axis >= 0 && session_.meshes()) {
    const mesh::Box box = mesh::boundingBox(session_.meshes()->meshes.skin);
    render::ClipPlane plane;
    plane.point = box.lo + (box.hi - box.lo) * static_cast<double>(clipAt_->value()) / kTicks;
    plane.normal = mesh::Vector3::Unit(axis) * (clipFlip_->isChecked() ? -1.0 : 1.0);
    d.clip = plane;
  }
  session_.setDisplay(d);
}

}  // namespace ecorche::studio
