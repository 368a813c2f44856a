#include <ecorche/studio/new_dialog.h>

#include <QComboBox>
#include <QDialogButtonBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QPushButton>
#include <QVBoxLayout>

namespace ecorche::studio {

namespace {

const char* const kMeshFilter = QT_TRANSLATE_NOOP(
    "ecorche::studio::NewDialog",
    "Meshes (*.obj *.ply *.stl *.off *.glb *.gltf *.fbx *.dae *.3ds);;All files (*)");

std::filesystem::path pathOf(const QString& text) {
  return std::filesystem::path(text.trimmed().toStdString());
}

bool soundsLikeSkin(const QString& file) {
  const QString name = QFileInfo(file).baseName();
  for (const char* word : {"skin", "body", "haut", "outer"}) {
    if (name.contains(word, Qt::CaseInsensitive)) return true;
  }
  return false;
}

}  // namespace

NewDialog::NewDialog(QWidget* parent) : QDialog(parent) {
  setObjectName("newDialog");
  setWindowTitle(tr("New from skin and bones"));
  setMinimumWidth(560);
  auto* layout = new QVBoxLayout(this);
  auto* form = new QFormLayout;
  layout->addLayout(form);

  const auto fileRow = [&](const char* name, const QString& label, const QString& hint, bool many) {
    auto* row = new QWidget(this);
    auto* both = new QHBoxLayout(row);
    both->setContentsMargins(0, 0, 0, 0);
    auto* line = new QLineEdit(row);
    line->setObjectName(name);
    line->setPlaceholderText(hint);
    auto* button = new QPushButton(tr("Choose …"), row);
    both->addWidget(line, 1);
    both->addWidget(button);
    form->addRow(label, row);
    connect(button, &QPushButton::clicked, this, [this, line, many] { browse(line, many); });
    connect(line, &QLineEdit::textChanged, this, &NewDialog::look);
    return line;
  };
  skin_ = fileRow("newSkin", tr("Skin"), tr("leave empty: one is laid around the bones"), false);
  bones_ = fileRow("newBones", tr("Bones"), tr("files or a folder, several divided by ;"), true);
  unit_ = new QComboBox(this);
  unit_->setObjectName("newUnit");
  for (const auto unit :
       {model::Unit::Metre, model::Unit::Centimetre, model::Unit::Millimetre, model::Unit::Inch})
    unit_->addItem(QString::fromStdString(std::string(model::symbol(unit))),
                   static_cast<int>(unit));
  form->addRow(tr("Unit of the files"), unit_);
  symmetry_ = new QComboBox(this);
  symmetry_->setObjectName("newSymmetry");
  symmetry_->addItem(tr("keep the whole body"), "none");
  symmetry_->addItem(tr("find the plane, keep one half"), "auto");
  form->addRow(tr("Symmetry"), symmetry_);

  target_ = new QLineEdit(this);
  target_->setObjectName("newTarget");
  connect(target_, &QLineEdit::textEdited, this, [this] {
    targetChosen_ = true;
    look();
  });
  form->addRow(tr("Project file"), target_);
  trouble_ = new QLabel(this);
  trouble_->setWordWrap(true);
  layout->addWidget(trouble_);
  buttons_ = new QDialogButtonBox(QDialogButtonBox::Ok | QDialogButtonBox::Cancel, this);
  buttons_->button(QDialogButtonBox::Ok)->setText(tr("Make project"));
  connect(buttons_, &QDialogButtonBox::accepted, this, &QDialog::accept);
  connect(buttons_, &QDialogButtonBox::rejected, this, &QDialog::reject);
  layout->addWidget(buttons_);
  look();
}

void NewDialog::browse(QLineEdit* line, bool many) {
  if (many) {
    const QStringList files = QFileDialog::getOpenFileNames(this, tr("Bones"), {}, tr(kMeshFilter));
    if (!files.isEmpty()) line->setText(files.join(";"));
  } else {
    const QString file = QFileDialog::getOpenFileName(this, tr("Skin"), {}, tr(kMeshFilter));
    if (!file.isEmpty()) line->setText(file);
  }
}

void NewDialog::take(const QStringList& files) {
  QStringList bones;
  for (const QString& file : files) {
    if (skin_->text().isEmpty() && soundsLikeSkin(file)) {
      skin_->setText(file);
    } else {
      bones << file;
    }
  }
  bones_->setText(bones.join(";"));
}

// Says what is missing while it is missing, and proposes a place for the project
void NewDialog::look() {
  const QString first = skin_->text().isEmpty() ? bones_->text().section(';', 0, 0) : skin_->text();
  if (!targetChosen_) {
    const QFileInfo info(first);
    const QString stem = info.isDir() ? info.fileName() : info.dir().dirName();
    target_->setText(first.isEmpty()
                         ? QString()
                         : (info.isDir() ? QDir(first) : info.dir()).filePath(stem + ".ecorche"));
  }
  QString trouble;
  if (first.isEmpty()) {
    trouble = tr("Choose a skin, or bones, or both");
  } else {
    QStringList all = bones_->text().split(';', Qt::SkipEmptyParts);
    if (!skin_->text().isEmpty()) all.prepend(skin_->text());
    for (const QString& file : all) {
      if (!QFileInfo::exists(file.trimmed())) trouble = tr("There is no file %1").arg(file);
    }
    if (trouble.isEmpty() && QFileInfo::exists(target_->text()))
      trouble = tr("%1 exists already; choose another name").arg(target_->text());
  }
  trouble_->setText(trouble);
  buttons_->button(QDialogButtonBox::Ok)->setEnabled(trouble.isEmpty());
}

authoring::NewProjectRequest NewDialog::request() const {
  authoring::NewProjectRequest out;
  out.target = pathOf(target_->text());
  if (!skin_->text().trimmed().isEmpty()) out.skin = pathOf(skin_->text());
  for (const QString& bone : bones_->text().split(';', Qt::SkipEmptyParts))
    out.bones.push_back(pathOf(bone));
  out.unit = static_cast<model::Unit>(unit_->currentData().toInt());
  if (const auto parsed =
          authoring::symmetryFrom(symmetry_->currentData().toString().toStdString(), out.unit))
    out.symmetry = *parsed;
  return out;
}

}  // namespace ecorche::studio
