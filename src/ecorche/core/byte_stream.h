#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace ecorche {

/// Plain values one after another, in this machine's byte order: for files that never leave the
/// machine (between us and the worker, in the cache). Texts and matrices carry their sizes.
class ByteWriter {
 public:
  template <class T>
  void value(T x) {
    static_assert(std::is_arithmetic_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&x), sizeof x);
  }
  void text(std::string_view s) {
    value(static_cast<std::uint64_t>(s.size()));
    bytes_.append(s);
  }
  template <class Matrix>
  void matrix(const Matrix& m) {  ///< any plain Eigen matrix
    value(static_cast<std::uint64_t>(m.rows()));
    value(static_cast<std::uint64_t>(m.cols()));
    bytes_.append(reinterpret_cast<const char*>(m.data()),
                  sizeof(typename Matrix::Scalar) * static_cast<std::size_t>(m.size()));
  }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads what ByteWriter wrote. Every size is checked against what is left, so any bytes at all are
/// safe to read: once something does not fit, ok() is false and everything after reads as zero or
/// empty.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : rest_(bytes) {}

  [[nodiscard]] bool ok() const { return ok_; }
  /// Everything was read, and it fitted.
  [[nodiscard]] bool finished() const { return ok_ && rest_.empty(); }

  /// For who finds that what fits makes no sense.
  void reject() { ok_ = false; }

  template <class T>
  [[nodiscard]] T value() {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    T x{};
    if (take(sizeof x)) std::memcpy(&x, taken_.data(), sizeof x);
    return x;
  }
  [[nodiscard]] std::string text() {
    return take(value<std::uint64_t>()) ? std::string(taken_) : "";
  }

  /// A matrix of this type; fixed dimensions must agree with what was written.
  template <class Matrix>
  [[nodiscard]] Matrix matrix() {
    const auto rows = value<std::uint64_t>();
    const auto cols = value<std::uint64_t>();
    constexpr std::uint64_t kSane = std::uint64_t{1} << 32;
    constexpr auto fits = [](std::uint64_t n, int fixed) {
      return n < kSane && (fixed < 0 || n == static_cast<std::uint64_t>(fixed));
    };
    if (!fits(rows, Matrix::RowsAtCompileTime) || !fits(cols, Matrix::ColsAtCompileTime) ||
        (cols > 0 && rows > rest_.size() / cols)) {
      ok_ = false;
    }
    const std::uint64_t size = ok_ ? rows * cols * sizeof(typename Matrix::Scalar) : 0;
    if (!take(size))
      return Matrix::Zero(fixedOrNone(Matrix::RowsAtCompileTime),
                          fixedOrNone(Matrix::ColsAtCompileTime));
    Matrix m(static_cast<std::int64_t>(rows), static_cast<std::int64_t>(cols));
    if (size > 0) std::memcpy(m.data(), taken_.data(), size);
    return m;
  }

 private:
  static constexpr int fixedOrNone(int n) { return n < 0 ? 0 : n; }
  bool take(std::uint64_t size) {
    if (!ok_ || size > rest_.size()) {
      ok_ = false;
      return false;
    }
    taken_ = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return true;
  }

  std::string_view rest_;
  std::string_view taken_;
  bool ok_ = true;
};

}  // namespace ecorche
