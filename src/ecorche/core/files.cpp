#include <ecorche/core/claim.h>
#include <ecorche/core/files.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <optional>
#include <vector>

namespace ecorche {

namespace fs = std::filesystem;

namespace {

constexpr int kAttempts = 100;

// Staged under a hidden sibling's name that no other process and no other thread of this one uses
std::string stagingPrefix(const fs::path& target) {
  return "." + target.filename().string() + ".ecorche-";
}
fs::path stagingPath(const fs::path& target) {
  static std::atomic<int> counter{0};
  return target.parent_path() / fmt::format("{}{}-{}", stagingPrefix(target), getpid(), counter++);
}

fs::path absoluteTarget(const fs::path& target) {
  fs::path full = fs::absolute(target).lexically_normal();
  if (!full.has_filename()) full = full.parent_path();
  return full;
}

}  // namespace

Result<std::string> readFile(const fs::path& file) {
  std::error_code ec;
  if (!fs::exists(file, ec)) {
    return fail(ErrorCode::FileMissing, "there is no such file; check the path",
                {.file = file.string()});
  }
  if (fs::is_directory(file, ec)) {
    return fail(ErrorCode::FileNotReadable, "this is a folder, a file is needed",
                {.file = file.string()});
  }
  std::ifstream in(file, std::ios::binary | std::ios::ate);
  if (!in) {
    return fail(ErrorCode::FileNotReadable,
                fmt::format("the file cannot be opened: {}", std::strerror(errno)),
                {.file = file.string()});
  }
  std::string bytes(static_cast<std::size_t>(in.tellg()), '\0');
  in.seekg(0);
  in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!in) {
    return fail(ErrorCode::FileNotReadable, "the file cannot be read to its end",
                {.file = file.string()});
  }
  if (bytes.empty()) {
    return fail(ErrorCode::FileEmpty, "the file is empty; export it again",
                {.file = file.string()});
  }
  return bytes;
}

Result<void> writeFileWhole(const fs::path& file, std::string_view bytes) {
  const fs::path target = absoluteTarget(file);
  removeUnclaimed(target.parent_path(), stagingPrefix(target));
  fs::path staged;
  const auto refuse = [&](const char* act) {
    const int code = errno;
    ::unlink(staged.c_str());
    return fail(ErrorCode::FileNotWritable,
                fmt::format("cannot {} the file: {}; choose another folder or free some space", act,
                            std::strerror(code)),
                {.file = file.string()});
  };

  // Somebody who clears up may take the file away before we hold it
  int fd = -1;
  std::optional<Claim> claim;
  for (int attempt = 0; attempt < kAttempts && !claim; ++attempt) {
    if (fd >= 0) {
      if (fs::exists(staged)) break;  // a file system without locks
      ::close(fd);
    }
    staged = stagingPath(target);
    fd = ::open(staged.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0 && errno != EEXIST) return refuse("create");
    if (fd >= 0) claim = Claim::waitFor(staged);
  }
  if (fd < 0) return refuse("create");
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::write(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int code = errno;
      ::close(fd);
      errno = code;
      return refuse("write");
    }
    done += static_cast<std::size_t>(n);
  }
  if (::fsync(fd) != 0 && errno != EINVAL && errno != EROFS) {
    const int code = errno;
    ::close(fd);
    errno = code;
    return refuse("flush");
  }
  ::close(fd);
  if (::rename(staged.c_str(), target.c_str()) != 0) return refuse("replace");
  return {};
}

struct StagedFolder::Impl {
  fs::path target;
  Replaceable ours;
  fs::path staged;
  std::optional<Claim> claim;
  std::vector<fs::path> madeParents;  // outermost first
  bool committed = false;
  ~Impl() {
    if (committed) return;
    std::error_code ignored;
    if (!staged.empty()) fs::remove_all(staged, ignored);
    // Where somebody else put something meanwhile, they stay
    for (auto parent = madeParents.rbegin(); parent != madeParents.rend(); ++parent)
      fs::remove(*parent, ignored);
  }
};

namespace {

tl::unexpected<Error> notWritable(const fs::path& place, std::string message) {
  return fail(ErrorCode::FileNotWritable, std::move(message), {.file = place.string()});
}

// Something in an existing folder that a replacement would destroy
std::optional<std::string> foreignEntry(const fs::path& folder, const Replaceable& ours) {
  std::error_code ec;
  fs::directory_iterator entries(folder, ec);
  if (ec || entries == fs::directory_iterator()) return std::nullopt;
  std::string first;
  for (const auto& entry : entries) {
    std::string file = entry.path().filename().string();
    if (std::ranges::find(ours.names, file) == ours.names.end()) return file;
    first = std::move(file);
  }
  if (ours.mark.empty() || !fs::exists(folder / ours.mark, ec)) return first;
  return std::nullopt;
}

std::string wouldBeLost(const std::string& entry) {
  return fmt::format(
      "this folder holds \"{}\", which was not written here and would be lost; name a new folder",
      entry);
}

void flushFolder(const fs::path& folder) {
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;
  ::fsync(fd);
  ::close(fd);
}

void flushFolders(const fs::path& top) {
  std::error_code ec;
  for (const auto& entry : fs::recursive_directory_iterator(top, ec)) {
    if (entry.is_directory(ec)) flushFolder(entry.path());
  }
  flushFolder(top);
}

Result<void> makeParents(const fs::path& target, std::vector<fs::path>& made) {
  std::vector<fs::path> missing;
  std::error_code ec;
  for (fs::path p = target.parent_path(); !fs::exists(p, ec); p = p.parent_path())
    missing.push_back(p);
  for (auto p = missing.rbegin(); p != missing.rend(); ++p) {
    if (::mkdir(p->c_str(), 0777) == 0) {
      made.push_back(*p);
    } else if (errno != EEXIST) {
      return notWritable(
          target, fmt::format("the folder {} cannot be created ({}); write elsewhere", p->string(),
                              std::strerror(errno)));
    }
  }
  return {};
}

}  // namespace

StagedFolder::StagedFolder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
StagedFolder::StagedFolder(StagedFolder&&) noexcept = default;
StagedFolder& StagedFolder::operator=(StagedFolder&&) noexcept = default;
StagedFolder::~StagedFolder() = default;

Result<StagedFolder> StagedFolder::create(const fs::path& target, const Replaceable& ours) {
  if (target.empty()) return notWritable(target, "the output has no name; name a folder");
  auto impl = std::make_unique<Impl>();
  impl->target = absoluteTarget(target);
  impl->ours = ours;
  std::error_code ec;
  if (fs::exists(impl->target, ec)) {
    if (!fs::is_directory(impl->target, ec))
      return notWritable(target, "the output is a file, a folder is needed; name another");
    if (!impl->target.has_filename())
      return notWritable(target, "the root of the file system cannot be replaced; name a folder");
    if (const auto foreign = foreignEntry(impl->target, ours))
      return notWritable(target, wouldBeLost(*foreign));
    // Renaming needs write permission on the parent; replacing needs it on the old folder as well
    if (::access(impl->target.c_str(), W_OK) != 0)
      return notWritable(
          target, "the output folder may not be written; change its permissions or name another");
  }
  removeUnclaimed(impl->target.parent_path(), stagingPrefix(impl->target));
  // Somebody who clears up may take the folder away before we hold it, or its parents
  for (int attempt = 0; attempt < kAttempts && !impl->claim; ++attempt) {
    if (!impl->staged.empty() && fs::exists(impl->staged, ec))
      break;  // a file system without locks
    if (auto made = makeParents(impl->target, impl->madeParents); !made) return passOn(made);
    const fs::path staged = stagingPath(impl->target);
    if (::mkdir(staged.c_str(), 0777) == 0) {
      impl->staged = staged;
      impl->claim = Claim::waitFor(staged);
    } else if (errno != EEXIST && errno != ENOENT) {
      break;
    }
  }
  if (impl->staged.empty()) {
    return notWritable(target,
                       fmt::format("nothing can be created in {} ({}); write elsewhere",
                                   impl->target.parent_path().string(), std::strerror(errno)));
  }
  return StagedFolder(std::move(impl));
}

const fs::path& StagedFolder::path() const { return impl_->staged; }

Result<void> StagedFolder::commit() {
  const auto refuse = [&](const char* act) {
    return fail(ErrorCode::FileNotWritable,
                fmt::format("cannot {} the output folder: {}", act, std::strerror(errno)),
                {.file = impl_->target.string()});
  };
  // Files were flushed one by one; their names are the folders' content
  flushFolders(impl_->staged);
  // Much may have happened there since create()
  if (const auto foreign = foreignEntry(impl_->target, impl_->ours))
    return notWritable(impl_->target, wouldBeLost(*foreign));
  std::error_code ec;
#ifdef RENAME_EXCHANGE
  // Swap old and new in one step, so that the name never stands for nothing; then drop the old one.
  // Where there is none yet, take the name unless another program does so first: then swap
  const auto renameAs = [&](unsigned flags) {
    return ::renameat2(AT_FDCWD, impl_->staged.c_str(), AT_FDCWD, impl_->target.c_str(), flags) ==
           0;
  };
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const bool fresh = renameAs(RENAME_NOREPLACE);
    if (!fresh && errno != EEXIST) break;
    if (!fresh && !renameAs(RENAME_EXCHANGE)) {
      if (errno == ENOENT) continue;  // and gone again
      break;
    }
    impl_->committed = true;
    flushFolder(impl_->target.parent_path());
    if (!fresh) fs::remove_all(impl_->staged, ec);
    return {};
  }
#endif
  // A file system that knows neither
  if (!fs::exists(impl_->target, ec)) {
    if (::rename(impl_->staged.c_str(), impl_->target.c_str()) != 0) return refuse("rename");
    impl_->committed = true;
    flushFolder(impl_->target.parent_path());
    return {};
  }
  const fs::path old = stagingPath(impl_->target);
  if (::rename(impl_->target.c_str(), old.c_str()) != 0) return refuse("replace");
  if (::rename(impl_->staged.c_str(), impl_->target.c_str()) != 0) {
    const int code = errno;
    ::rename(old.c_str(), impl_->target.c_str());
    errno = code;
    return refuse("replace");
  }
  impl_->committed = true;
  fs::remove_all(old, ec);
  return {};
}

struct Hasher::Impl {
  XXH3_state_t* state = XXH3_createState();
  ~Impl() { XXH3_freeState(state); }
};

Hasher::Hasher() : impl_(std::make_unique<Impl>()) { XXH3_128bits_reset(impl_->state); }
Hasher::~Hasher() = default;

void Hasher::bytes(const void* data, std::size_t size) {
  if (size > 0) XXH3_128bits_update(impl_->state, data, size);
}
void Hasher::text(std::string_view s) {
  number(static_cast<std::int64_t>(s.size()));
  bytes(s.data(), s.size());
}
void Hasher::number(double x) { bytes(&x, sizeof x); }
void Hasher::number(std::int64_t x) { bytes(&x, sizeof x); }

std::string Hasher::hex() const {
  const XXH128_hash_t h = XXH3_128bits_digest(impl_->state);
  return fmt::format("{:016x}{:016x}", h.high64, h.low64);
}

fs::path cacheFolder() {
  if (const char* own = std::getenv("ECORCHE_CACHE"); own != nullptr && *own != '\0') return own;
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg != nullptr && *xdg != '\0') {
    return fs::path(xdg) / "ecorche";
  }
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0') {
    return fs::path(home) / ".cache" / "ecorche";
  }
  return fs::temp_directory_path() / "ecorche-cache";
}

fs::path programFolder() {
  std::error_code ec;
  const fs::path self = fs::read_symlink("/proc/self/exe", ec);
  return ec ? fs::current_path() : self.parent_path();
}

}  // namespace ecorche
