#include <ecorche/core/give_way.h>
#include <ecorche/core/parallel.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

using namespace ecorche;

namespace {

int niceHere() { return getpriority(PRIO_PROCESS, static_cast<id_t>(syscall(SYS_gettid))); }

}  // namespace

TEST_CASE("a thread that gives way does so with its helpers, others do not") {
  const int usual = niceHere();
  std::atomic<int> least{100};
  std::thread([&] {
    const GiveWay giveWay;
    parallelFor(
        64,
        [&](std::int64_t) {
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
          int now = least;
          while (niceHere() < now && !least.compare_exchange_weak(now, niceHere())) {
          }
        },
        1);
  }).join();
  CHECK(least >= std::max(usual, 5));
  CHECK(niceHere() == usual);
}
