#include "bench/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <utility>

#include "boxunion/error.hpp"

namespace boxunion {
namespace {

void print(const std::vector<std::string>& cells) {
  fmt::print("| {} |\n", fmt::join(cells, " | "));
  std::fflush(stdout);
}

}  // namespace

void Tables::begin(const std::string& name, std::vector<std::string> columns) {
  print(columns);
  print(std::vector<std::string>(columns.size(), "---"));
  if (tables_.empty() || tables_.back().name != name)
    tables_.push_back({.name = name, .columns = {}, .rows = {}});
  tables_.back().columns = std::move(columns);
}

void Tables::add_row(std::vector<Cell> row) {
  std::vector<std::string> texts;
  for (const Cell& cell : row)
    if (const double* const number = std::get_if<double>(&cell))
      texts.push_back(fmt::format("{:.4g}", *number));
    else
      texts.push_back(std::visit([](const auto& value) { return fmt::format("{}", value); }, cell));
  print(texts);
  tables_.back().rows.push_back(std::move(row));
}

void Tables::write(const std::string& path) const {
  nlohmann::ordered_json file;
  for (const Table& table : tables_) {
    auto& rows = file[table.name] = nlohmann::ordered_json::array();
    for (const std::vector<Cell>& cells : table.rows) {
      auto& row = rows.emplace_back();
      for (std::size_t i = 0; i < cells.size(); ++i)
        std::visit([&](const auto& value) { row[table.columns.at(i)] = value; }, cells[i]);
    }
  }
  std::ofstream out(path);
  out << file.dump(1) << '\n';
  if (!out.flush()) throw Error(ErrorKind::resources, "cannot write " + path);
}

}  // namespace boxunion
