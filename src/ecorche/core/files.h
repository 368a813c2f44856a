#pragma once

#include <ecorche/core/result.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace ecorche {

/// The whole file as bytes. @errors FileMissing, FileNotReadable, FileEmpty
[[nodiscard]] Result<std::string> readFile(const std::filesystem::path& file);

/// Writes beside the target, flushes to disk, then renames: a reader sees the old bytes or the new
/// ones.
/// @errors FileNotWritable
[[nodiscard]] Result<void> writeFileWhole(const std::filesystem::path& file,
                                          std::string_view bytes);

/// What a folder of an earlier run looks like, which may be replaced. Anything else in it is
/// somebody's work.
struct Replaceable {
  std::string mark;  ///< a file that every such folder has
  std::vector<std::string>
      names;  ///< all that may lie in it, the mark among them; folders with all they hold
};

/// A folder that appears under its name only when commit() succeeds: it is written under a hidden
/// sibling's name and renamed. An existing target is replaced by commit() and left alone by
/// anything else. Destroyed uncommitted, it removes what it wrote; leftovers of killed processes
/// are removed by the next create() for the same target.
class StagedFolder {
 public:
  /// Makes missing parents, too; they go again if nothing is committed.
  /// @param ours  what an existing target may be; an empty folder may always be replaced
  /// @errors FileNotWritable: no permission, a file in the way, or a folder that holds something
  /// else
  [[nodiscard]] static Result<StagedFolder> create(const std::filesystem::path& target,
                                                   const Replaceable& ours = {});
  StagedFolder(StagedFolder&&) noexcept;
  StagedFolder& operator=(StagedFolder&&) noexcept;
  ~StagedFolder();

  /// Where to write before commit().
  [[nodiscard]] const std::filesystem::path& path() const;
  /// @errors FileNotWritable
  [[nodiscard]] Result<void> commit();

 private:
  struct Impl;
  explicit StagedFolder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// 128-bit content hash as 32 hex digits (XXH3), for cache keys: fast, not for security.
class Hasher {
 public:
  Hasher();
  ~Hasher();
  Hasher(const Hasher&) = delete;
  Hasher& operator=(const Hasher&) = delete;

  void bytes(const void* data, std::size_t size);
  void text(std::string_view s);  ///< length first, so that "ab","c" and "a","bc" differ
  void number(double x);
  void number(std::int64_t x);
  template <class Matrix>
  void matrix(const Matrix& m) {  ///< any plain Eigen matrix: sizes and coefficients
    number(static_cast<std::int64_t>(m.rows()));
    number(static_cast<std::int64_t>(m.cols()));
    bytes(m.data(), sizeof(typename Matrix::Scalar) * static_cast<std::size_t>(m.size()));
  }
  [[nodiscard]] std::string hex() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// ~/.cache/ecorche or what ECORCHE_CACHE and XDG_CACHE_HOME say. Not created here.
[[nodiscard]] std::filesystem::path cacheFolder();

/// Folder of the running program, for its sibling ecorche-worker. ECORCHE_WORKER overrides the
/// worker's path.
[[nodiscard]] std::filesystem::path programFolder();

}  // namespace ecorche
