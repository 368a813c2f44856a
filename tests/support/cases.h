#pragma once

#include <cstdint>
#include <cstdlib>
#include <vector>

namespace ecorche::test {

#ifdef __SANITIZE_ADDRESS__
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// Which of `count` cases of one kind run here: all of them. Under sanitizers, where each takes
/// many times as long, a quarter of them, every fourth from the one that ECORCHE_TURN (0) names:
/// four turns see all. `script/soak` turns by the day. Kinds of cases that come again every odd
/// number of cases are all met in a quarter of enough of them.
inline std::vector<std::uint64_t> casesHere(std::uint64_t count) {
  constexpr std::uint64_t kParts = kSanitized ? 4 : 1;
  const char* turn = std::getenv("ECORCHE_TURN");
  std::vector<std::uint64_t> out;
  for (std::uint64_t i = turn == nullptr ? 0 : std::strtoull(turn, nullptr, 10) % kParts; i < count;
       i += kParts)
    out.push_back(i);
  return out;
}

}  // namespace ecorche::test
