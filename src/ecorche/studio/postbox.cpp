#include <ecorche/studio/postbox.h>

#include <QCoreApplication>
#include <QEvent>
#include <utility>

namespace ecorche::studio {

void Postbox::post(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(work));
  }
  QCoreApplication::postEvent(this, new QEvent(QEvent::User));
}

bool Postbox::event(QEvent* event) {
  if (event->type() != QEvent::User) return QObject::event(event);
  std::function<void()> work;
  {
    const std::lock_guard lock(mutex_);
    work = std::move(waiting_.front());
    waiting_.pop_front();
  }
  work();  // which may be the end of this
  return true;
}

}  // namespace ecorche::studio
