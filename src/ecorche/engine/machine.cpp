#include <cblas.h>
#include <ecorche/core/parallel.h>
#include <ecorche/engine/machine.h>

#include <fstream>
#include <thread>

namespace ecorche::engine {

namespace {

std::string processorName() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);) {
    if (!line.starts_with("model name")) continue;
    const auto colon = line.find(':');
    return colon == std::string::npos ? line : line.substr(colon + 2);
  }
  return "unknown";
}

}  // namespace

exchange::MachineFigures thisMachine() {
  return {processorName(), static_cast<std::int64_t>(std::thread::hardware_concurrency()),
          threadCount(), openblas_get_config()};
}

}  // namespace ecorche::engine
