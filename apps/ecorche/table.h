#pragma once

#include <string>
#include <vector>

namespace ecorche::cli {

/// A table for a terminal: columns as wide as their widest cell (counted in characters, not bytes),
/// two blanks between.
class Table {
 public:
  enum class Align { Left, Right };
  struct Column {
    std::string title;
    Align align = Align::Left;
  };
  explicit Table(std::vector<Column> columns);

  /// @param cells  one per column
  void add(std::vector<std::string> cells);
  /// With the titles underlined; every line ends in a newline.
  [[nodiscard]] std::string text() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace ecorche::cli
