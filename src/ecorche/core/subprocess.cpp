#include <ecorche/core/files.h>
#include <ecorche/core/subprocess.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>

extern char** environ;  // NOLINT: POSIX declares it nowhere

namespace ecorche {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::size_t kLastWordsKept = 4096;
constexpr int kPatienceMs = 20;

#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define ECORCHE_SHADOW_MEMORY  // as clang says it
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(ECORCHE_SHADOW_MEMORY)
constexpr bool kLimitMemory = false;  // its shadow memory alone is larger than any limit
#else
constexpr bool kLimitMemory = true;
#endif

// The end of what a process says, whatever the amount.
class Tail {
 public:
  void add(std::string_view bytes) {
    text_.append(bytes);
    if (text_.size() > 2 * kLastWordsKept) text_.erase(0, text_.size() - kLastWordsKept);
  }
  [[nodiscard]] std::string text() const {
    std::string_view t = text_;
    if (t.size() > kLastWordsKept) t.remove_prefix(t.size() - kLastWordsKept);
    while (!t.empty() && (t.back() == '\n' || t.back() == '\r' || t.back() == ' '))
      t.remove_suffix(1);
    return std::string(t);
  }

 private:
  std::string text_;
};

std::string_view lastLine(std::string_view text) {
  const auto end = text.rfind('\n');
  return end == std::string_view::npos ? text : text.substr(end + 1);
}

std::string lastSaid(const std::string& lastWords) {
  return lastWords.empty() ? "it said nothing"
                           : fmt::format("its last words: {}", lastLine(lastWords));
}

// A pipe's reading end, never blocking.
class Ear {
 public:
  explicit Ear(int fd) : fd_(fd) { ::fcntl(fd, F_SETFL, O_NONBLOCK); }
  ~Ear() { ::close(fd_); }
  Ear(const Ear&) = delete;
  Ear& operator=(const Ear&) = delete;

  // Waits for words at most so long; false once nobody can say any more.
  bool listen(int milliseconds, Tail& heard) {
    pollfd waiting{fd_, POLLIN, 0};
    if (::poll(&waiting, 1, milliseconds) <= 0) return true;
    char buffer[4096];
    while (true) {
      const ssize_t n = ::read(fd_, buffer, sizeof buffer);
      if (n > 0) {
        heard.add({buffer, static_cast<std::size_t>(n)});
      } else if (n == 0) {
        return false;
      } else if (errno != EINTR) {
        return errno == EAGAIN || errno == EWOULDBLOCK;
      }
    }
  }

 private:
  int fd_;
};

// Child in a group of its own; /dev/null as input, one pipe for both outputs, nothing else
// inherited.
int spawn(const fs::path& program, const std::vector<std::string>& arguments, int output,
          pid_t& pid) {
  std::vector<char*> argv;
  std::string name = program.string();
  argv.push_back(name.data());
  for (const auto& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
  argv.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output, 1);
  posix_spawn_file_actions_adddup2(&files, output, 2);
  posix_spawn_file_actions_addclosefrom_np(&files, 3);

  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
  posix_spawnattr_setpgroup(&attributes, 0);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);

  const int failure = ::posix_spawn(&pid, name.c_str(), &files, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return failure;
}

}  // namespace

Result<ProcessEnd> runProcess(const fs::path& program, const std::vector<std::string>& arguments,
                              const ProcessOptions& options, RunContext& run) {
  if (run.cancelled()) return fail(ErrorCode::Cancelled, "interrupted");
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    return fail(ErrorCode::Internal, fmt::format("no pipe to be had: {}", std::strerror(errno)));
  }
  Ear ear(ends[0]);
  const auto begin = Clock::now();
  pid_t pid = 0;
  const int refused = spawn(program, arguments, ends[1], pid);
  ::close(ends[1]);
  if (refused == ENOENT || refused == EACCES || refused == ENOEXEC || refused == ENOTDIR) {
    return fail(ErrorCode::WorkerMissing,
                fmt::format("the program cannot be started: {}; install Écorché again or let "
                            "ECORCHE_WORKER name ecorche-worker",
                            std::strerror(refused)),
                {.file = program.string()});
  }
  if (refused != 0) {
    return fail(ErrorCode::Internal,
                fmt::format("cannot start a process: {}", std::strerror(refused)),
                {.file = program.string()});
  }
  if (kLimitMemory && options.memoryLimit > 0) {
    const rlimit limit{options.memoryLimit, options.memoryLimit};
    ::prlimit(pid, RLIMIT_AS, &limit, nullptr);
  }

  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  Tail heard;
  int status = 0;
  rusage used{};
  bool talking = true;
  std::optional<ErrorCode> killedFor;
  while (true) {
    if (talking) {
      talking = ear.listen(kPatienceMs, heard);
    } else {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    // Left as a zombie for now, so that its number still means our group below
    siginfo_t ended{};
    const int failure = ::waitid(P_PID, static_cast<id_t>(pid), &ended,
                                 WEXITED | WNOWAIT | (killedFor ? 0 : WNOHANG));
    if ((failure == 0 && ended.si_pid == pid) || (failure != 0 && errno != EINTR)) break;
    if (run.cancelled()) killedFor = ErrorCode::Cancelled;
    if (!killedFor && seconds() > options.timeout) killedFor = ErrorCode::WorkerTimedOut;
    if (killedFor) ::kill(-pid, SIGKILL);
  }
  ::kill(-pid, SIGKILL);  // whatever it left running
  while (::wait4(pid, &status, 0, &used) < 0 && errno == EINTR) {
  }
  if (talking) ear.listen(0, heard);

  ProcessEnd end{.exitCode = WIFEXITED(status) ? WEXITSTATUS(status) : -1,
                 .lastWords = heard.text(),
                 .seconds = seconds(),
                 .peakMemory = static_cast<std::size_t>(used.ru_maxrss) * 1024};
  if (killedFor == ErrorCode::Cancelled) return fail(ErrorCode::Cancelled, "interrupted");
  const std::string name = program.filename().string();
  if (killedFor == ErrorCode::WorkerTimedOut) {
    return fail(ErrorCode::WorkerTimedOut,
                fmt::format("{} did not finish within {:.4g} s and was stopped; {}", name,
                            options.timeout, lastSaid(end.lastWords)));
  }
  if (WIFSIGNALED(status)) {
    // Where memory runs out the system kills whom it likes
    return fail(
        ErrorCode::WorkerCrashed,
        fmt::format("{} crashed ({}{}) after {:.1f} s; {}", name, ::strsignal(WTERMSIG(status)),
                    WTERMSIG(status) == SIGKILL ? ", perhaps because memory ran out" : "",
                    end.seconds, lastSaid(end.lastWords)));
  }
  return end;
}

std::size_t workerMemoryLimit() {
  const auto pages = static_cast<std::size_t>(::sysconf(_SC_PHYS_PAGES));
  return pages / 4 * 3 * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

Result<fs::path> findWorker() {
  const char* own = std::getenv("ECORCHE_WORKER");
  const bool named = own != nullptr && *own != '\0';
  fs::path worker = named ? fs::path(own) : programFolder() / "ecorche-worker";
  std::error_code ec;
  if (!fs::is_regular_file(worker, ec) || ::access(worker.c_str(), X_OK) != 0) {
    return fail(ErrorCode::WorkerMissing,
                named ? "ECORCHE_WORKER names no program; unset it or correct it"
                      : "ecorche-worker must lie beside this program; install Écorché again or let "
                        "ECORCHE_WORKER name it",
                {.file = worker.string()});
  }
  return worker;
}

Result<ProcessEnd> runWorker(const std::vector<std::string>& arguments,
                             const ProcessOptions& options, RunContext& run) {
  const auto worker = findWorker();
  if (!worker) return passOn(worker);
  auto end = runProcess(*worker, arguments, options, run);
  if (!end || end->exitCode == 0) return end;

  // "error CODE SENTENCE" in the last line, or an end that nobody planned
  std::string_view line = lastLine(end->lastWords);
  constexpr std::string_view kPrefix = "error ";
  if (end->exitCode == 1 && line.starts_with(kPrefix)) {
    line.remove_prefix(kPrefix.size());
    const auto space = line.find(' ');
    const auto code = errorCodeNamed(line.substr(0, space));
    if (code && space != std::string_view::npos)
      return fail(*code, std::string(line.substr(space + 1)));
  }
  return fail(ErrorCode::WorkerCrashed, fmt::format("ecorche-worker gave up with exit code {}; {}",
                                                    end->exitCode, lastSaid(end->lastWords)));
}

std::string workerErrorLine(const Error& error) {
  std::string sentence = error.message;
  for (char& c : sentence) {
    if (c == '\n' || c == '\r') c = ' ';
  }
  return fmt::format("error {} {}", name(error.code), sentence);
}

Result<ScratchFolder> ScratchFolder::create() {
  constexpr std::string_view kPrefix = "ecorche-scratch-";
  std::error_code ec;
  const fs::path base = fs::temp_directory_path(ec);
  const fs::path folder = ec ? fs::path("/tmp") : base;
  removeUnclaimed(folder, kPrefix);
  std::string path;
  // Somebody who clears up may take the folder away before we hold it
  for (int attempt = 0; attempt < 100; ++attempt) {
    path = (folder / (std::string(kPrefix) + "XXXXXX")).string();
    if (::mkdtemp(path.data()) == nullptr) break;
    auto claim = Claim::take(path);
    if (claim || fs::exists(path, ec)) return ScratchFolder(path, std::move(claim));
  }
  return fail(ErrorCode::FileNotWritable,
              fmt::format("cannot make a temporary folder: {}; let TMPDIR name a folder with space",
                          std::strerror(errno)),
              {.file = folder.string()});
}

ScratchFolder::ScratchFolder(ScratchFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})), claim_(std::move(other.claim_)) {}

ScratchFolder& ScratchFolder::operator=(ScratchFolder&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(claim_, other.claim_);
  return *this;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  if (!path_.empty()) fs::remove_all(path_, ignored);
}

}  // namespace ecorche
