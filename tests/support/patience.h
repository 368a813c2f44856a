#pragma once

namespace ecorche::test {

/// By how much longer than usual something may take before it counts as hanging: sanitizers slow
/// all work down, and more so on a busy machine.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr int kPatience = 20;
#else
inline constexpr int kPatience = 1;
#endif

}  // namespace ecorche::test
