#include <ecorche/core/run_context.h>

#include <sys/resource.h>

#include <algorithm>

namespace ecorche {

void RunContext::progress(std::string_view stage, double fraction) {
  if (!sink_) return;
  const std::lock_guard lock(mutex_);
  sink_(stage, std::clamp(fraction, 0.0, 1.0));
}

void RunContext::record(std::string_view stage, double seconds) {
  const std::lock_guard lock(mutex_);
  const auto known =
      std::ranges::find_if(times_, [&](const StageTime& t) { return t.stage == stage; });
  if (known != times_.end()) {
    known->seconds += seconds;
  } else {
    times_.push_back({std::string(stage), seconds});
  }
}

std::vector<RunContext::StageTime> RunContext::stageTimes() const {
  const std::lock_guard lock(mutex_);
  return times_;
}

double RunContext::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

Stage::Stage(RunContext& run, std::string stage) : run_(run), stage_(std::move(stage)) {
  run_.progress(stage_, 0.0);
}

Stage::~Stage() {
  run_.progress(stage_, 1.0);
  run_.record(stage_, seconds());
}

double Stage::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

namespace {
std::size_t maxResident(int who) {
  rusage usage{};
  getrusage(who, &usage);
#ifdef __APPLE__
  return static_cast<std::size_t>(usage.ru_maxrss);
#else
  return static_cast<std::size_t>(usage.ru_maxrss) * 1024;
#endif
}
}  // namespace

std::size_t peakMemory() { return maxResident(RUSAGE_SELF); }
std::size_t peakMemoryOfChildren() { return maxResident(RUSAGE_CHILDREN); }

}  // namespace ecorche
