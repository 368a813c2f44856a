#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

namespace ecorche {

/// A hold on a file or folder that ends with its process, whatever ends that: an advisory lock on
/// the thing itself.
///
/// What a killed process left behind is what nobody holds. Process ids would not do: in a container
/// every run may have the same one.
class Claim {
 public:
  /// Nothing where somebody else holds it, it is gone, or the file system knows no locks.
  [[nodiscard]] static std::optional<Claim> take(const std::filesystem::path& path);
  /// The same for one's own fresh thing, on which somebody who clears up may have a hand at this
  /// moment: waits until he is done. Nothing where it is gone then, or without locks.
  [[nodiscard]] static std::optional<Claim> waitFor(const std::filesystem::path& path);
  Claim(Claim&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Claim& operator=(Claim&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~Claim();

 private:
  explicit Claim(int fd) : fd_(fd) {}
  static std::optional<Claim> lock(const std::filesystem::path& path, int how);
  int fd_ = -1;  // -1: moved from
};

/// Removes the entries of a folder whose names begin with `prefix` and that nobody holds.
void removeUnclaimed(const std::filesystem::path& folder, std::string_view prefix);

}  // namespace ecorche
