#pragma once

#include <ecorche/core/claim.h>
#include <ecorche/core/result.h>
#include <ecorche/core/run_context.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace ecorche {

struct ProcessOptions {
  /// Wall time after which the process and its children are killed [s].
  double timeout = 600.0;
  /// Address space the process may use [bytes]; 0: as much as it wants. Not enforced under
  /// AddressSanitizer.
  std::size_t memoryLimit = 0;
};

/// What a worker may use at most, so that it does not take us down with it: three quarters of the
/// machine's memory [bytes].
[[nodiscard]] std::size_t workerMemoryLimit();

/// How a process ended of its own accord.
struct ProcessEnd {
  int exitCode = 0;
  std::string lastWords;  ///< the last lines it wrote to standard output and error, at most 4 KiB
  double seconds = 0.0;   ///< wall time
  std::size_t peakMemory = 0;  ///< its largest resident set [bytes]
};

/// Runs a program to its end, without a shell, in a process group of its own, with no standard
/// input. When it takes too long or `run` is cancelled, the whole group is killed; the answer to a
/// cancel takes at most about 20 ms.
///
/// @return  any exit code; what it means is the caller's affair
/// @errors  WorkerMissing (no such program), WorkerCrashed (ended by a signal, with its last
/// words), WorkerTimedOut,
///          Cancelled, Internal (the system refuses to start a process)
[[nodiscard]] Result<ProcessEnd> runProcess(const std::filesystem::path& program,
                                            const std::vector<std::string>& arguments,
                                            const ProcessOptions& options, RunContext& run);

/// Where ecorche-worker is: what ECORCHE_WORKER names, or beside the running program. @errors
/// WorkerMissing
[[nodiscard]] Result<std::filesystem::path> findWorker();

/// Runs `ecorche-worker ARGUMENTS…`, which must exit 0.
///
/// The worker reports a fault of its input by exit code 1 and a last line `error CODE SENTENCE`
/// (see workerError).
/// @errors  what the worker reported; WorkerCrashed for any other end; those of runProcess and
/// findWorker
[[nodiscard]] Result<ProcessEnd> runWorker(const std::vector<std::string>& arguments,
                                           const ProcessOptions& options, RunContext& run);

/// The line by which a worker tells its error to runWorker.
[[nodiscard]] std::string workerErrorLine(const Error& error);

/// A folder under the system's temporary folder that nobody else uses, removed with everything in
/// it at the end; what killed processes left there goes with the next create().
class ScratchFolder {
 public:
  /// @errors FileNotWritable
  [[nodiscard]] static Result<ScratchFolder> create();
  ScratchFolder(ScratchFolder&& other) noexcept;
  ScratchFolder& operator=(ScratchFolder&& other) noexcept;
  ~ScratchFolder();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  ScratchFolder(std::filesystem::path path, std::optional<Claim> claim)
      : path_(std::move(path)), claim_(std::move(claim)) {}
  std::filesystem::path path_;  // empty: moved from
  std::optional<Claim> claim_;  // none: the file system knows no locks
};

}  // namespace ecorche
