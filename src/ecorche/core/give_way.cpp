#include <ecorche/core/give_way.h>

#ifdef __linux__
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace ecorche {
namespace {

void giveWayHere() {
#ifdef __linux__
  // Against threads of usual priority a third is left while all are busy. A thread that gave way
  // already stays where it is; if the system refuses, it is as fast as before
  constexpr int kNice = 5;
  const auto thread = static_cast<id_t>(syscall(SYS_gettid));
  if (getpriority(PRIO_PROCESS, thread) < kNice) setpriority(PRIO_PROCESS, thread, kNice);
#endif
}

}  // namespace

GiveWay::GiveWay() {
  giveWayHere();
  observe(true);
}

GiveWay::~GiveWay() { observe(false); }

void GiveWay::on_scheduler_entry(bool isWorker) {
  if (isWorker) giveWayHere();
}

}  // namespace ecorche
