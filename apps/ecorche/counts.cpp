#include "counts.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace ecorche::cli {

Result<std::int64_t> parseCount(const std::string& text) {
  double value = 0.0;
  const auto [end, ec] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string rest(end, text.data() + text.size());
  const double factor = rest.empty()                 ? 1.0
                        : rest == "k" || rest == "K" ? 1e3
                        : rest == "M" || rest == "m" ? 1e6
                                                     : 0.0;
  value = std::round(value * factor);
  if (ec != std::errc() || factor == 0.0 || !(value >= 1000.0 && value <= 1e8)) {
    return fail(
        ErrorCode::ValueOutOfRange,
        fmt::format("\"{}\" is no number of tets; write 200000, 200k or 1.3M, from 1k to 100M",
                    text));
  }
  return static_cast<std::int64_t>(value);
}

Result<std::optional<std::int64_t>> parseCountIfAny(const std::string& text) {
  if (text.empty()) return std::optional<std::int64_t>();
  const auto count = parseCount(text);
  if (!count) return passOn(count);
  return *count;
}

Result<std::vector<std::int64_t>> parseCounts(const std::vector<std::string>& texts) {
  std::vector<std::int64_t> out;
  for (const std::string& text : texts) {
    const auto count = parseCount(text);
    if (!count) return passOn(count);
    out.push_back(*count);
  }
  return out;
}

}  // namespace ecorche::cli
