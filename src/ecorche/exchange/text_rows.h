#pragma once

#include <ecorche/core/parallel.h>

#include <charconv>
#include <cstdint>
#include <string>
#include <vector>

namespace ecorche::exchange {

/// Writes numbers of one row into a buffer that is long enough.
class RowWriter {
 public:
  explicit RowWriter(char* at) : at_(at) {}
  void integer(std::int64_t x) { at_ = std::to_chars(at_, at_ + 24, x).ptr; }
  /// Shortest decimals that read back to the same bits.
  void number(double x) { at_ = std::to_chars(at_, at_ + 32, x).ptr; }
  void put(char c) { *at_++ = c; }
  [[nodiscard]] char* end() const { return at_; }

 private:
  char* at_;
};

/// Appends count rows, each at most mostBytes long; row(i, RowWriter&) writes one. Blocks in
/// parallel, bytes in order.
template <class Row>
void appendRows(std::string& out, std::int64_t count, std::size_t mostBytes, const Row& row) {
  constexpr std::int64_t kBlock = 16384;
  const std::int64_t blockCount = (count + kBlock - 1) / kBlock;
  std::vector<std::string> blocks(static_cast<std::size_t>(blockCount));
  parallelFor(
      blockCount,
      [&](std::int64_t b) {
        std::string& text = blocks[static_cast<std::size_t>(b)];
        const std::int64_t first = b * kBlock;
        const std::int64_t last = std::min(count, first + kBlock);
        text.resize(static_cast<std::size_t>(last - first) * mostBytes);
        RowWriter writer(text.data());
        for (std::int64_t i = first; i < last; ++i) row(i, writer);
        text.resize(static_cast<std::size_t>(writer.end() - text.data()));
      },
      1);
  std::size_t size = out.size();
  for (const std::string& block : blocks) size += block.size();
  out.reserve(size);
  for (std::string& block : blocks) {
    out += block;
    std::string().swap(block);
  }
}

}  // namespace ecorche::exchange
