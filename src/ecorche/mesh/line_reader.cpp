#include <ecorche/mesh/line_reader.h>
#include <fmt/format.h>

namespace ecorche::mesh {

namespace {

// Words go into messages for people: short, and nothing a terminal would act on.
std::string shown(std::string_view word) {
  constexpr std::size_t kMost = 24;
  std::string out(word.substr(0, kMost));
  for (char& c : out) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  }
  return word.size() > kMost ? out + "…" : out;
}

}  // namespace

Result<void> LineReader::oddNumber(double& x, const char* what) {
  const char* first = at_ + (at_ < stop_ && *at_ == '+');
  const auto [end, ec] = std::from_chars(first, stop_, x);
  if (ec != std::errc::result_out_of_range || !(end == stop_ || isBlank(*end) || continues(end))) {
    return badWord("a number", what);
  }
  // Too small for a double, or too large
  const std::string_view digits(first, static_cast<std::size_t>(end - first));
  const auto exponent = digits.find_first_of("eE");
  const bool small = exponent != digits.npos && digits.substr(exponent + 1).starts_with('-');
  x = small ? 0.0 : std::numeric_limits<double>::infinity();
  at_ = end;
  return {};
}

tl::unexpected<Error> LineReader::badWord(const char* kind, const char* what) {
  const std::string_view found = word();
  if (found.empty()) return missing(fmt::format("{} for {}", kind, what));
  const bool comma = found.find(',') != found.npos;
  return fault(
      fmt::format("{} should be {}, not \"{}\"{}", what, kind, shown(found),
                  comma ? "; write decimals with a point, numbers with blanks between" : ""));
}

tl::unexpected<Error> LineReader::errorHere(ErrorCode code, std::string message) const {
  return fail(code, std::move(message), {.file = file_, .line = line_});
}

tl::unexpected<Error> LineReader::fault(std::string message) const {
  return errorHere(ErrorCode::FileSyntax, std::move(message));
}

tl::unexpected<Error> LineReader::missing(const std::string& what) const {
  if (breaksOff()) return brokenOff(fmt::format("it lacks {}", what));
  return fault(fmt::format("the line lacks {}", what));
}

tl::unexpected<Error> LineReader::brokenOff(const std::string& message) const {
  return errorHere(ErrorCode::FileTruncated,
                   fmt::format("the file breaks off here: {}; copy or export it again", message));
}

}  // namespace ecorche::mesh
