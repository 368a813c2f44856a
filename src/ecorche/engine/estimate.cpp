#include <ecorche/engine/estimate.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>

namespace ecorche::engine {

namespace {

// Fitted to peaks and times of whole builds (docs/decisions.md)
constexpr double kBytesAtRest = 1e8;
constexpr double kBytesPerFace = 500;
constexpr double kBytesPerTet = 1600;
constexpr double kBytesPerTetAndMuscle = 3.0;
constexpr double kSecondsAtRest = 8.0;
constexpr double kSecondsPerFace = 4e-5;
constexpr double kSecondsPerTet = 6e-5;

std::string bytesText(double bytes) {
  return bytes < 1e9 ? fmt::format("{:.0f} MB", bytes * 1e-6)
                     : fmt::format("{:.1f} GB", bytes * 1e-9);
}
std::string countText(double count) {
  return count < 1e6 ? fmt::format("{:.0f} k", count * 1e-3)
                     : fmt::format("{:.2g} M", count * 1e-6);
}
std::string timeText(double seconds) {
  return seconds < 90 ? fmt::format("{:.0f} s", seconds) : fmt::format("{:.0f} min", seconds / 60);
}

/// The number after a key of /proc/meminfo, or alone in a file of a control group.
std::int64_t numberIn(const char* file, const std::string& key, std::int64_t unit) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(key)) continue;
    const char* digits = line.c_str() + line.find_first_of("0123456789m");
    if (*digits == 'm') break;  // "max"
    return unit * std::strtoll(digits, nullptr, 10);
  }
  return std::numeric_limits<std::int64_t>::max();
}

double bytesOf(double tets, double muscles, double faces) {
  return kBytesAtRest + kBytesPerFace * faces +
         tets * (kBytesPerTet + kBytesPerTetAndMuscle * muscles);
}

}  // namespace

std::string Estimate::text() const {
  return fmt::format("about {} tets, {} and {}", countText(static_cast<double>(tets)),
                     bytesText(static_cast<double>(memoryBytes)), timeText(seconds));
}

Estimate estimateBuild(std::int64_t tets, std::int64_t muscles, std::int64_t faces) {
  const auto t = static_cast<double>(tets);
  const auto f = static_cast<double>(faces);
  return {.tets = tets,
          .memoryBytes = std::llround(bytesOf(t, static_cast<double>(muscles), f)),
          .seconds = kSecondsAtRest + kSecondsPerFace * f + kSecondsPerTet * t};
}

std::int64_t availableMemory() {
  if (const char* own = std::getenv("ECORCHE_MEMORY")) return std::strtoll(own, nullptr, 10);
  const std::int64_t machine = numberIn("/proc/meminfo", "MemAvailable:", 1024);
  const std::int64_t limit = numberIn("/sys/fs/cgroup/memory.max", "", 1);
  if (limit == std::numeric_limits<std::int64_t>::max()) return machine;
  const std::int64_t used = numberIn("/sys/fs/cgroup/memory.current", "", 1);
  return std::min(machine, std::max<std::int64_t>(0, limit - std::min(limit, used)));
}

Result<void> requireMemory(const Estimate& estimate, std::int64_t muscles, std::int64_t faces) {
  const std::int64_t available = availableMemory();
  if (estimate.memoryBytes <= available) return {};
  const double rest = static_cast<double>(available) -
                      bytesOf(0.0, static_cast<double>(muscles), static_cast<double>(faces));
  const double each = bytesOf(1.0, static_cast<double>(muscles), 0.0) -
                      bytesOf(0.0, static_cast<double>(muscles), 0.0);
  const double most = std::floor(rest / each * 1e-4) * 1e4;
  const std::string needs = fmt::format("{} tets need about {} of memory, and {} are free; ",
                                        countText(static_cast<double>(estimate.tets)),
                                        bytesText(static_cast<double>(estimate.memoryBytes)),
                                        bytesText(static_cast<double>(available)));
  return fail(ErrorCode::OutOfMemory,
              needs + (most >= 1e4 ? fmt::format("ask for {} or fewer (--tets {:.0f}k)",
                                                 countText(most), most * 1e-3)
                                   : std::string("close other programs or take a larger machine")));
}

}  // namespace ecorche::engine
