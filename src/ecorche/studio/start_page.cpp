#include <ecorche/studio/start_page.h>

#include <QFileInfo>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>

namespace ecorche::studio {

namespace {

constexpr int kMostRecent = 6;

QPushButton* wide(const QString& text, const char* name, QWidget* parent) {
  auto* button = new QPushButton(text, parent);
  button->setObjectName(name);
  button->setMinimumSize(380, 44);
  button->setCursor(Qt::PointingHandCursor);
  return button;
}

}  // namespace

StartPage::StartPage(QWidget* parent) : QWidget(parent) {
  setObjectName("startPage");
  auto* outer = new QHBoxLayout(this);
  auto* column = new QVBoxLayout;
  outer->addStretch(1);
  outer->addLayout(column);
  outer->addStretch(1);
  column->addStretch(2);

  auto* title = new QLabel(tr("Écorché"), this);
  QFont font = title->font();
  font.setPointSizeF(font.pointSizeF() * 3.2);
  font.setWeight(QFont::Light);
  title->setFont(font);
  auto* words =
      new QLabel(tr("Skin and bones in, a curve from bone to bone, and there is a muscle."), this);
  words->setForegroundRole(QPalette::PlaceholderText);
  column->addWidget(title);
  column->addWidget(words);
  column->addSpacing(24);

  QPushButton* fresh = wide(tr("New from skin and bones …"), "startNew", this);
  QPushButton* open = wide(tr("Open a project …"), "startOpen", this);
  QPushButton* example = wide(tr("Try it on an arm"), "startExample", this);
  fresh->setDefault(true);
  for (QPushButton* button : {fresh, open, example}) column->addWidget(button);
  connect(fresh, &QPushButton::clicked, this, &StartPage::newAsked);
  connect(open, &QPushButton::clicked, this, &StartPage::openAsked);
  connect(example, &QPushButton::clicked, this, &StartPage::exampleAsked);
  auto* drop = new QLabel(tr("or drop meshes or a project anywhere in this window"), this);
  drop->setForegroundRole(QPalette::PlaceholderText);
  column->addWidget(drop);
  column->addSpacing(18);
  recent_ = new QVBoxLayout;
  column->addLayout(recent_);
  column->addStretch(3);
}

void StartPage::setRecent(const QStringList& files) {
  while (QLayoutItem* item = recent_->takeAt(0)) {
    delete item->widget();
    delete item;
  }
  for (const QString& file : files.mid(0, kMostRecent)) {
    auto* link = new QPushButton(QFileInfo(file).fileName(), this);
    link->setFlat(true);
    link->setToolTip(file);
    link->setCursor(Qt::PointingHandCursor);
    link->setStyleSheet("text-align: left;");
    connect(link, &QPushButton::clicked, this, [this, file] { Q_EMIT fileAsked(file); });
    recent_->addWidget(link);
  }
}

}  // namespace ecorche::studio
