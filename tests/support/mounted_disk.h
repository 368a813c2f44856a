#pragma once

#include <fmt/format.h>
#include <sys/mount.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>

namespace ecorche::test {

/// A disk of its own in memory, so that it can be full or read-only; gone at the end of the scope.
class MountedDisk {
 public:
  /// Nothing, and a loud word, where this process may not mount.
  [[nodiscard]] static std::unique_ptr<MountedDisk> create(const std::filesystem::path& folder,
                                                           int kilobytes) {
    std::filesystem::create_directories(folder);
    const std::string size = fmt::format("size={}k", kilobytes);
    if (mount("ecorche-test", folder.c_str(), "tmpfs", 0, size.c_str()) != 0) {
      WARN("SKIPPED: no disk can be mounted (" << std::strerror(errno)
                                               << "); this truth was not checked");
      return nullptr;
    }
    return std::unique_ptr<MountedDisk>(new MountedDisk(folder));
  }
  ~MountedDisk() { umount2(folder_.c_str(), MNT_DETACH); }
  MountedDisk(const MountedDisk&) = delete;
  MountedDisk& operator=(const MountedDisk&) = delete;

  void makeReadOnly() const {
    REQUIRE(mount(nullptr, folder_.c_str(), nullptr, MS_REMOUNT | MS_RDONLY, nullptr) == 0);
  }

 private:
  explicit MountedDisk(std::filesystem::path folder) : folder_(std::move(folder)) {}
  std::filesystem::path folder_;
};

}  // namespace ecorche::test
