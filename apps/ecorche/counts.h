#pragma once

#include <ecorche/core/result.h>

#include <cstdint>
#include <string>

namespace ecorche::cli {

/// "640000", "640k", "1.3M" as a count. @errors ValueOutOfRange
[[nodiscard]] Result<std::int64_t> parseCount(const std::string& text);

}  // namespace ecorche::cli
