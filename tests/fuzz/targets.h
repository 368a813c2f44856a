#pragma once

#include <span>
#include <string_view>

namespace ecorche::test {

/// Something that takes bytes from outside. Any bytes at all must end in a value that keeps its
/// promises or in an Error: a broken promise throws, and the sanitizers see the rest.
struct FuzzTarget {
  std::string_view name;  ///< also its folder under tests/fuzz/corpus
  void (*run)(std::string_view bytes);
};

[[nodiscard]] std::span<const FuzzTarget> fuzzTargets();

}  // namespace ecorche::test
