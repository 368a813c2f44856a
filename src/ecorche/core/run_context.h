#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche {

/// What a long computation is given besides its values: a place to report progress, a flag to stop,
/// a thread count.
///
/// Safe to share between threads: cancel() may come from anywhere, progress() and record() lock.
class RunContext {
 public:
  /// Called with the stage's name and its share done in [0, 1].
  using ProgressSink = std::function<void(std::string_view stage, double fraction)>;

  struct StageTime {
    std::string stage;
    double seconds = 0.0;
  };

  RunContext() = default;
  explicit RunContext(ProgressSink sink) : sink_(std::move(sink)) {}

  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

  void progress(std::string_view stage, double fraction);

  /// Wall time of a finished stage; shown in the report in the order of first appearance, same
  /// names added up.
  void record(std::string_view stage, double seconds);
  [[nodiscard]] std::vector<StageTime> stageTimes() const;
  /// Wall time since this was made. Stages may hold stages, so their sum means nothing.
  [[nodiscard]] double seconds() const;

 private:
  std::atomic<bool> cancelled_{false};
  ProgressSink sink_;
  mutable std::mutex mutex_;
  std::vector<StageTime> times_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Times a block: reports 0 on entry, 1 and the seconds on exit.
class Stage {
 public:
  Stage(RunContext& run, std::string stage);
  ~Stage();
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;
  [[nodiscard]] double seconds() const;

 private:
  RunContext& run_;
  std::string stage_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Largest resident set of this process so far [bytes].
[[nodiscard]] std::size_t peakMemory();
/// Largest resident set among finished child processes (the worker) [bytes].
[[nodiscard]] std::size_t peakMemoryOfChildren();

}  // namespace ecorche
