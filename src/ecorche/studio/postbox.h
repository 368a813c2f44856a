#pragma once

#include <QObject>
#include <deque>
#include <functional>
#include <mutex>

namespace ecorche::studio {

/// Where other threads leave what is to be done on the window's: done there one by one, in order,
/// and never once this is gone. What hands it over is a lock of ours, which sanitizers see into.
class Postbox : public QObject {
 public:
  /// From any thread, while this exists.
  void post(std::function<void()> work);

 protected:
  bool event(QEvent* event) override;

 private:
  std::mutex mutex_;
  std::deque<std::function<void()>> waiting_;
};

}  // namespace ecorche::studio
