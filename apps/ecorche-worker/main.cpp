// SPDX-License-Identifier: AGPL-3.0-or-later
//
// ecorche-worker: does in a process of its own what may crash, hang or eat all memory. Files in,
// files out; started by runWorker (core/subprocess.h), which reads the exit code and the last line
// of standard error.

#include <ecorche/core/subprocess.h>
#include <fmt/format.h>
#include <sys/resource.h>
#ifdef __linux__
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <unistd.h>
#endif

#include <cstdio>
#include <exception>
#include <new>

#include "worker.h"

namespace {

using namespace ecorche;

struct Subcommand {
  const char* name;
  Result<void> (*run)(const worker::Arguments&);
};

constexpr Subcommand kSubcommands[] = {
    {"fill", worker::fillSurface},
    {"import", worker::importMesh},
    {"tetrahedralize", worker::tetrahedralizeSurface},
};

Result<void> dispatch(const std::string& name, const worker::Arguments& arguments) {
  for (const auto& known : kSubcommands) {
    if (name != known.name) continue;
    try {
      return known.run(arguments);
    } catch (const std::bad_alloc&) {
      return fail(ErrorCode::OutOfMemory, fmt::format("not enough memory to {}", name));
    } catch (const std::exception& e) {
      return fail(ErrorCode::Internal, fmt::format("cannot {}: {}", name, e.what()));
    }
  }
  return fail(ErrorCode::Internal, fmt::format("ecorche-worker knows no subcommand {}", name));
}

}  // namespace

int main(int argc, char** argv) {
#ifdef __linux__
  // Nobody waits for us once the program is gone; it may be gone already, with the ear at our pipe
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  pollfd ear{STDERR_FILENO, 0, 0};
  if (::poll(&ear, 1, 0) > 0 && (ear.revents & POLLERR) != 0) return 1;
#endif
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);

  if (argc < 2) {
    fmt::print(stderr, "ecorche-worker is started by ecorche; it does nothing by itself\n");
    return 2;
  }
  const auto done = dispatch(argv[1], worker::Arguments(argv + 2, argv + argc));
  if (done) return 0;
  fmt::print(stderr, "{}\n", workerErrorLine(done.error()));
  return 1;
}
