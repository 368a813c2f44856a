#include <ecorche/core/claim.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>

namespace ecorche {

namespace fs = std::filesystem;

std::optional<Claim> Claim::take(const fs::path& path) { return lock(path, LOCK_NB); }

std::optional<Claim> Claim::waitFor(const fs::path& path) { return lock(path, 0); }

std::optional<Claim> Claim::lock(const fs::path& path, int how) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (fd < 0) return std::nullopt;
  Claim claim(fd);
  if (::flock(fd, LOCK_EX | how) != 0) return std::nullopt;
  // Whoever held it before us may have removed it: then this is a lock on nothing
  struct stat held {
  }, there{};
  const bool same = ::fstat(fd, &held) == 0 && ::lstat(path.c_str(), &there) == 0 &&
                    held.st_ino == there.st_ino && held.st_dev == there.st_dev;
  if (!same) return std::nullopt;
  return claim;
}

Claim::~Claim() {
  if (fd_ >= 0) ::close(fd_);
}

void removeUnclaimed(const fs::path& folder, std::string_view prefix) {
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored)) {
    if (!entry.path().filename().string().starts_with(prefix)) continue;
    if (const auto claim = Claim::take(entry.path())) fs::remove_all(entry.path(), ignored);
  }
}

}  // namespace ecorche
