#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>

namespace ecorche {

/// The caller broke a promise that the docstring asks for. Not for the world's faults: those are
/// Results.
class ContractError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

namespace detail {
[[noreturn]] void contractBroken(const char* file, int line, const std::string& what);
}

}  // namespace ecorche

/// Checked in every build; throws ContractError with the place.
#define EC_REQUIRE(condition)                                                            \
  do {                                                                                   \
    if (!(condition)) ::ecorche::detail::contractBroken(__FILE__, __LINE__, #condition); \
  } while (false)

/// As EC_REQUIRE, with both values in the message.
#define EC_REQUIRE_EQ(a, b)                                                                      \
  do {                                                                                           \
    const auto& ecLeft = (a);                                                                    \
    const auto& ecRight = (b);                                                                   \
    if (!(ecLeft == ecRight))                                                                    \
      ::ecorche::detail::contractBroken(                                                         \
          __FILE__, __LINE__, fmt::format("{} == {} ({} against {})", #a, #b, ecLeft, ecRight)); \
  } while (false)

/// Our own invariants: checked where ECORCHE_CHECKED is set (preset dev), free elsewhere.
#ifdef ECORCHE_CHECKED
#define EC_ASSERT(condition, ...)                                                                 \
  do {                                                                                            \
    if (!(condition))                                                                             \
      ::ecorche::detail::contractBroken(__FILE__, __LINE__,                                       \
                                        std::string(#condition ": ") + fmt::format(__VA_ARGS__)); \
  } while (false)
#else
#define EC_ASSERT(condition, ...) \
  do {                            \
  } while (false)
#endif
