#pragma once

#include <QStringList>
#include <QWidget>

class QVBoxLayout;

namespace ecorche::studio {

/// What is seen before a project is open: the ways to one.
class StartPage : public QWidget {
  Q_OBJECT

 public:
  explicit StartPage(QWidget* parent = nullptr);
  void setRecent(const QStringList& files);

 signals:
  void newAsked();
  void openAsked();
  void exampleAsked();
  void fileAsked(const QString& file);

 private:
  QVBoxLayout* recent_;
};

}  // namespace ecorche::studio
