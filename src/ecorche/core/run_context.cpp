#include <ecorche/core/run_context.h>

#include <sys/resource.h>

#include <algorithm>
#include <iterator>

namespace ecorche {

void RunContext::progress(std::string_view stage, double fraction) {
  if (!sink_) return;
  const std::lock_guard lock(mutex_);
  sink_(stage, std::clamp(fraction, 0.0, 1.0));
}

bool RunContext::open(const std::string& stage) {
  const std::lock_guard lock(mutex_);
  if (std::ranges::find(running_, stage, &Running::stage) != running_.end()) return false;
  const auto own = std::find_if(running_.rbegin(), running_.rend(), [](const Running& r) {
    return r.thread == std::this_thread::get_id();
  });
  const Running* around = own != running_.rend() ? &*own
                          : running_.empty()     ? nullptr
                                                 : &running_.front();
  const int level = around != nullptr ? around->level + 1 : 0;
  const std::string within = around != nullptr ? around->path : std::string();
  const std::string path = within + stage + '\n';
  running_.push_back({stage, path, level, std::this_thread::get_id()});
  if (std::ranges::find(times_, path, &Entry::path) != times_.end()) return true;
  // Behind all that is part of the same
  auto place = times_.end();
  while (place != times_.begin() && !std::prev(place)->path.starts_with(within)) --place;
  times_.insert(place, {path, {stage, 0.0, level}});
  return true;
}

void RunContext::close(const std::string& stage, double seconds) {
  const std::lock_guard lock(mutex_);
  const auto running = std::ranges::find(running_, stage, &Running::stage);
  std::ranges::find(times_, running->path, &Entry::path)->time.seconds += seconds;
  running_.erase(running);
}

std::vector<RunContext::StageTime> RunContext::stageTimes() const {
  const std::lock_guard lock(mutex_);
  std::vector<StageTime> out;
  for (const Entry& entry : times_) out.push_back(entry.time);
  return out;
}

double RunContext::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
}

Stage::Stage(RunContext& run, std::string stage)
    : run_(run), stage_(std::move(stage)), counts_(run.open(stage_)) {
  if (counts_) run_.progress(stage_, 0.0);
}

Stage::~Stage() {
  if (!counts_) return;
  run_.progress(stage_, 1.0);
  run_.close(stage_, seconds());
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
