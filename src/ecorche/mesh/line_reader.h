#pragma once

#include <ecorche/core/result.h>

#include <charconv>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>

namespace ecorche::mesh {

/// Walks a text file line by line and word by word, knows where it is, and makes the errors that
/// say so. Lines end in \n, \r\n or, where the first line does, \r. A word that begins with # ends
/// its line.
class LineReader {
 public:
  enum class Continuation { None, Backslash };

  /// @param bytes  must outlive the reader; views handed out point into it
  /// @param file   name for errors
  LineReader(std::string_view bytes, std::string file,
             Continuation continuation = Continuation::None)
      : begin_(bytes.data()),
        end_(bytes.data() + bytes.size()),
        next_(begin_),
        at_(begin_),
        stop_(begin_),
        file_(std::move(file)),
        backslash_(continuation == Continuation::Backslash) {
    const auto first = bytes.find_first_of("\r\n");
    if (first != bytes.npos && bytes[first] == '\r' && bytes.substr(first + 1, 1) != "\n")
      newline_ = '\r';
  }

  /// Goes to the next line that has a word; false at the end of the file.
  bool next() {
    while (next_ < end_) {
      takeLine();
      skipBlanks();
      if (at_ < stop_ && *at_ != '#') return true;
    }
    at_ = stop_;
    return false;
  }

  /// The next word of this line; empty at its end.
  std::string_view word() {
    skipBlanks();
    if (at_ == stop_ || *at_ == '#') return {};
    const char* first = at_;
    while (at_ < stop_ && !isBlank(*at_) && !continues(at_)) ++at_;
    return {first, static_cast<std::size_t>(at_ - first)};
  }

  /// What is left of this line, trimmed: names may hold blanks.
  std::string_view rest() {
    skipBlanks();
    const char* last = stop_;
    while (last > at_ && isBlank(last[-1])) --last;
    const std::string_view all(at_, static_cast<std::size_t>(last - at_));
    at_ = stop_;
    return all;
  }

  /// True where the line has no further word.
  bool atLineEnd() {
    skipBlanks();
    return at_ == stop_ || *at_ == '#';
  }

  /// The next word as a number; words like nan and inf are numbers. @errors FileSyntax,
  /// FileTruncated
  Result<void> number(double& x, const char* what) {
    skipBlanks();
    const char* first = at_ + (at_ < stop_ && *at_ == '+');
    const auto [end, ec] = std::from_chars(first, stop_, x);
    if (ec == std::errc() && (end == stop_ || isBlank(*end) || continues(end))) [[likely]] {
      at_ = end;
      return {};
    }
    return oddNumber(x, what);
  }

  /// The next word as a whole number. @errors FileSyntax, FileTruncated
  Result<void> integer(std::int64_t& x, const char* what) {
    skipBlanks();
    const char* first = at_ + (at_ < stop_ && *at_ == '+');
    const auto [end, ec] = std::from_chars(first, stop_, x);
    if (ec == std::errc() && (end == stop_ || isBlank(*end) || continues(end))) [[likely]] {
      at_ = end;
      return {};
    }
    return badWord("a whole number", what);
  }

  /// 1 for the first line.
  [[nodiscard]] int line() const { return line_; }
  /// Bytes read so far, for progress and for binary data after a header.
  [[nodiscard]] std::size_t offset() const { return static_cast<std::size_t>(next_ - begin_); }
  [[nodiscard]] std::size_t size() const { return static_cast<std::size_t>(end_ - begin_); }

  /// True on a last line without a line end.
  [[nodiscard]] bool breaksOff() const { return next_ == end_ && stop_ == end_; }

  /// FileSyntax at this line.
  [[nodiscard]] tl::unexpected<Error> fault(std::string message) const;
  /// Something is missing at the end of this line: FileTruncated where the file breaks off here,
  /// else FileSyntax.
  [[nodiscard]] tl::unexpected<Error> missing(const std::string& what) const;
  /// The file ended though more was announced: FileTruncated.
  [[nodiscard]] tl::unexpected<Error> brokenOff(const std::string& message) const;
  [[nodiscard]] tl::unexpected<Error> errorHere(ErrorCode code, std::string message) const;

 private:
  static bool isBlank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
  // A backslash that is the last thing on its physical line
  bool continues(const char* p) const {
    if (!backslash_ || *p != '\\') return false;
    const char* after = p + 1;
    if (after < stop_ && *after == '\r') ++after;
    return after >= stop_ || *after == newline_;
  }
  void skipBlanks() {
    while (at_ < stop_ && (isBlank(*at_) || continues(at_))) ++at_;
  }
  void takeLine() {
    line_ += 1 + extraLines_;
    extraLines_ = 0;
    at_ = next_;
    while (true) {
      const void* found = std::memchr(next_, newline_, static_cast<std::size_t>(end_ - next_));
      stop_ = found == nullptr ? end_ : static_cast<const char*>(found);
      next_ = found == nullptr ? end_ : stop_ + 1;
      if (!backslash_ || next_ == end_) return;
      const char* last = stop_;
      if (last > at_ && last[-1] == '\r') --last;
      if (last == at_ || last[-1] != '\\') return;
      ++extraLines_;
    }
  }

  Result<void> oddNumber(double& x, const char* what);
  tl::unexpected<Error> badWord(const char* kind, const char* what);

  const char* begin_;
  const char* end_;
  const char* next_;  // first byte after this line
  const char* at_;    // next unread byte of this line
  const char* stop_;  // end of this line
  std::string file_;
  int line_ = 0;
  int extraLines_ = 0;  // physical lines joined to this one
  char newline_ = '\n';
  bool backslash_;
};

}  // namespace ecorche::mesh
