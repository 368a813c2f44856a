#pragma once

#include <ecorche/core/result.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace ecorche::cli {

/// "640000", "640k", "1.3M" as a count. @errors ValueOutOfRange
[[nodiscard]] Result<std::int64_t> parseCount(const std::string& text);
/// Nothing of an empty text: the project's own is meant.
[[nodiscard]] Result<std::optional<std::int64_t>> parseCountIfAny(const std::string& text);
[[nodiscard]] Result<std::vector<std::int64_t>> parseCounts(const std::vector<std::string>& texts);

}  // namespace ecorche::cli
