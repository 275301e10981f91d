#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"

namespace boxunion {

/// The tables of a benchmark: printed as Markdown row by row, and kept for a file of JSON, an array of rows a
/// table, each an object by the names of the columns.
class Tables {
 public:
  /// Declares `--json FILE`.
  explicit Tables(CLI::App& app) {
    app.add_option("--json", path_, "Also write the tables to FILE")->type_name("FILE");
  }
  Tables(const Tables&) = delete;
  Tables& operator=(const Tables&) = delete;

  /// Begins a table, or goes on with the last one.
  void begin(const std::string& name, std::vector<std::string> columns) {
    if (!tables_.contains(name)) tables_[name] = nlohmann::ordered_json::array();
    name_ = name;
    columns_ = std::move(columns);
    print(columns_);
    print(std::vector<std::string>(columns_.size(), "---"));
  }
  /// A row of as many cells as there are columns: numbers or texts.
  template <class... Cells>
  void add(const Cells&... cells) {
    auto& row = tables_[name_].emplace_back();
    std::size_t column = 0;
    ((row[columns_.at(column++)] = cells), ...);
    print({text(cells)...});
  }
  /// Writes the file, if one was asked for. Throws Error(resources) where that fails.
  void write() const {
    if (path_.empty()) return;
    std::ofstream file(path_);
    file << tables_.dump(1) << '\n';
    if (!file.flush()) throw Error(ErrorKind::resources, "cannot write " + path_);
  }

 private:
  static std::string text(double value) { return fmt::format("{:.4g}", value); }
  template <class T>
  static std::string text(const T& value) {
    return fmt::format("{}", value);
  }
  static void print(const std::vector<std::string>& cells) {
    fmt::print("| {} |\n", fmt::join(cells, " | "));
    std::fflush(stdout);
  }

  std::string path_, name_;
  std::vector<std::string> columns_;
  nlohmann::ordered_json tables_ = nlohmann::ordered_json::object();
};

}  // namespace boxunion
