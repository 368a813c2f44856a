#pragma once

#include <span>
#include <stdexcept>
#include <string_view>

namespace ecorche::test {

/// Something that takes bytes from outside. Any bytes at all must end in a value that keeps its
/// promises or in an Error: a broken promise throws, and the sanitizers see the rest.
struct FuzzTarget {
  std::string_view name;  ///< also its folder under tests/fuzz/corpus
  void (*run)(std::string_view bytes);
};

/// What users bring: meshes, projects, scripts of commands.
[[nodiscard]] std::span<const FuzzTarget> inputTargets();

/// What we wrote ourselves, and somebody may have damaged: outputs, the cache, what goes between us
/// and the worker; and tables of attachments.
[[nodiscard]] std::span<const FuzzTarget> ownTargets();

inline void demand(bool promise, const char* what) {
  if (!promise) throw std::logic_error(what);
}

}  // namespace ecorche::test
