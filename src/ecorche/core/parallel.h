#pragma once

#include <ecorche/core/handover.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <cstdint>

namespace ecorche {

/// body(i) for every i in [0, count), on as many threads as the process was given (see
/// ThreadLimit). Chunks have a fixed size, so what a body writes to slots of its own index is the
/// same for any thread count.
template <class Body>
void parallelFor(std::int64_t count, const Body& body, std::int64_t grain = 1024) {
  const char begin = 0;
  const char end = 0;
  handOver(&begin);
  tbb::parallel_for(
      tbb::blocked_range<std::int64_t>(0, count, grain),
      [&](const tbb::blocked_range<std::int64_t>& range) {
        takeOver(&begin);
        for (std::int64_t i = range.begin(); i < range.end(); ++i) body(i);
        handOver(&end);
      },
      tbb::simple_partitioner());
  takeOver(&end);
}

/// How many threads parallelFor uses while this object lives. 0: all cores.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads);
  ~ThreadLimit();
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;

 private:
  struct Impl;
  Impl* impl_;
};

/// Threads in force now.
[[nodiscard]] int threadCount();

}  // namespace ecorche
