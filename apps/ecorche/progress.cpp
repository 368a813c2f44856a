#include "progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace ecorche::cli {

using namespace std::chrono_literals;

ProgressPrinter::ProgressPrinter(bool quiet)
    : quiet_(quiet), terminal_(isatty(STDERR_FILENO) == 1) {}
ProgressPrinter::~ProgressPrinter() { finish(); }

void ProgressPrinter::show(std::string_view stage, double fraction) {
  if (quiet_) return;
  const auto now = Clock::now();
  auto known = begun_.find(stage);
  if (known == begun_.end()) known = begun_.emplace(std::string(stage), Begun{now, now}).first;
  Begun& begun = known->second;
  const double seconds = std::chrono::duration<double>(now - begun.at).count();
  const bool done = fraction >= 1.0;

  if (done) {
    finish();
    // What took no time is not worth a line
    if (seconds >= 0.05) fmt::print(stderr, "{:>7.2f} s  {}\n", seconds, stage);
    begun_.erase(known);
  } else if (terminal_) {
    if (drawn_ && now - lastDrawn_ < 50ms) return;
    constexpr int kWidth = 30;
    const int full = static_cast<int>(std::lround(fraction * kWidth));
    fmt::print(stderr, "\r\033[K[{:#<{}}{:.<{}}] {:3.0f} %  {}", "", full, "", kWidth - full,
               100 * fraction, stage);
    drawn_ = true;
    lastDrawn_ = now;
  } else if (now - begun.lastLine >= 10s) {
    fmt::print(stderr, "{:>7.2f} s  {}: {:.0f} %\n", seconds, stage, 100 * fraction);
    begun.lastLine = now;
  }
  std::fflush(stderr);
}

void ProgressPrinter::finish() {
  if (drawn_) fmt::print(stderr, "\r\033[K");
  drawn_ = false;
  std::fflush(stderr);
}

}  // namespace ecorche::cli
