#pragma once

#include <chrono>
#include <map>
#include <string>
#include <string_view>

namespace ecorche::cli {

/// Progress on standard error: a bar that redraws itself on a terminal, elsewhere a plain line per
/// finished stage and one every ten seconds of a long stage. Not thread-safe by itself: RunContext
/// locks around its sink.
class ProgressPrinter {
 public:
  explicit ProgressPrinter(bool quiet);
  ~ProgressPrinter();
  ProgressPrinter(const ProgressPrinter&) = delete;
  ProgressPrinter& operator=(const ProgressPrinter&) = delete;

  void show(std::string_view stage, double fraction);
  /// Takes the bar off the screen, for whoever prints next.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;
  struct Begun {
    Clock::time_point at;
    Clock::time_point lastLine;
  };
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  Clock::time_point lastDrawn_;
  std::map<std::string, Begun, std::less<>> begun_;
};

}  // namespace ecorche::cli
