#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
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
    int level =
        0;  ///< 0: a stage of its own; more: part of the last one before it of a lower level
  };

  RunContext() = default;
  explicit RunContext(ProgressSink sink) : sink_(std::move(sink)) {}

  void cancel() { cancelled_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled() const { return cancelled_.load(std::memory_order_relaxed); }

  void progress(std::string_view stage, double fraction);

  /// Wall times of stages in the order in which they began, each followed by its parts; same names
  /// added up within one part. Stages that began while another ran on their thread are part of that
  /// one; the first of another thread are part of the outermost that ran. Those of level 0 add up
  /// to the whole.
  [[nodiscard]] std::vector<StageTime> stageTimes() const;
  /// Wall time since this was made.
  [[nodiscard]] double seconds() const;

 private:
  friend class Stage;
  /// @return false where a stage of that name runs already: its time counts once
  bool open(const std::string& stage);
  void close(const std::string& stage, double seconds);

  std::atomic<bool> cancelled_{false};
  ProgressSink sink_;
  mutable std::mutex mutex_;
  struct Entry {
    std::string path;  // names from the outermost on, a line each
    StageTime time;
  };
  struct Running {
    std::string stage;
    std::string path;
    int level = 0;
    std::thread::id thread;
  };
  std::vector<Entry> times_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  std::vector<Running> running_;
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
  bool counts_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

/// Largest resident set of this process so far [bytes].
[[nodiscard]] std::size_t peakMemory();
/// Largest resident set among finished child processes (the worker) [bytes].
[[nodiscard]] std::size_t peakMemoryOfChildren();

}  // namespace ecorche
