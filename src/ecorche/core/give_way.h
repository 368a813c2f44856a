#pragma once

#include <tbb/task_scheduler_observer.h>

namespace ecorche {

/// Makes the thread that holds it, and workers that come to help it (parallelFor), give way to all
/// others when there are not cores enough for everybody: for what is computed beside a window.
/// A thread that gave way once does so from then on; the system lets nobody take that back.
/// Where the system knows no priorities of threads nothing happens.
class GiveWay : private tbb::task_scheduler_observer {
 public:
  GiveWay();
  ~GiveWay() override;
  GiveWay(const GiveWay&) = delete;
  GiveWay& operator=(const GiveWay&) = delete;

 private:
  void on_scheduler_entry(bool isWorker) override;
};

}  // namespace ecorche
