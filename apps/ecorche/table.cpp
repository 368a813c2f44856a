#include "table.h"

#include <ecorche/core/contract.h>

#include <algorithm>

namespace ecorche::cli {

namespace {
// Characters of a UTF-8 text: bytes that do not continue another
std::size_t width(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}
}  // namespace

Table::Table(std::vector<Column> columns) : columns_(std::move(columns)) {}

void Table::add(std::vector<std::string> cells) {
  EC_REQUIRE_EQ(cells.size(), columns_.size());
  rows_.push_back(std::move(cells));
}

std::string Table::text() const {
  std::vector<std::vector<std::string>> lines;
  std::vector<std::string> titles, rules;
  std::vector<std::size_t> widest;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    std::size_t w = width(columns_[c].title);
    for (const auto& row : rows_) w = std::max(w, width(row[c]));
    widest.push_back(w);
    titles.push_back(columns_[c].title);
    rules.push_back(std::string(w, '-'));
  }
  lines.push_back(titles);
  lines.push_back(rules);
  lines.insert(lines.end(), rows_.begin(), rows_.end());

  std::string out;
  for (const auto& line : lines) {
    std::string text;
    for (std::size_t c = 0; c < line.size(); ++c) {
      const std::string pad(widest[c] - width(line[c]), ' ');
      if (c > 0) text += "  ";
      text += columns_[c].align == Align::Right ? pad + line[c] : line[c] + pad;
    }
    text.erase(text.find_last_not_of(' ') + 1);
    out += text + "\n";
  }
  return out;
}

}  // namespace ecorche::cli
