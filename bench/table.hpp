#pragma once

#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace boxunion {

/// The tables of a benchmark. They are printed as Markdown, row by row, and kept for a JSON file: an array of
/// rows for each table, in which a row is an object by the names of the columns.
class Tables {
 public:
  /// Begins a table, or continues the last one.
  void begin(const std::string& name, std::vector<std::string> columns);
  /// Adds a row with a cell for each column. Cells are numbers or texts.
  template <class... Cells>
  void add(const Cells&... cells) {
    add_row({cell(cells)...});
  }
  /// Writes the JSON file. Throws Error(resources) if that fails.
  void write(const std::string& path) const;

 private:
  using Cell = std::variant<std::int64_t, double, std::string>;
  struct Table {
    std::string name;
    std::vector<std::string> columns;
    std::vector<std::vector<Cell>> rows;
  };

  template <class T>
  static Cell cell(const T& value) {
    if constexpr (std::integral<T>)
      return static_cast<std::int64_t>(value);
    else
      return value;
  }
  void add_row(std::vector<Cell> row);

  std::vector<Table> tables_;
};

}  // namespace boxunion
