#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/command/command_text.hpp"

namespace boxunion::command {

/// The shortest decimal that reads back to the same double; null if it is infinite, which JSON cannot say.
std::string json_number(double value);

/// One result: a member of the JSON object and a row of the plain table.
struct Result {
  std::string key;   ///< with underscores, which are spaces in the table
  std::string json;  ///< a JSON value
  std::string text;  ///< for the table: one or more printable lines
};

Result count_result(const std::string& key, std::uint64_t count);
Result number_result(const std::string& key, double value);
Result string_result(const std::string& key, const std::string& text);
/// Seconds by stage. The table shows only the last stage, the total.
Result seconds_result(const std::vector<std::pair<std::string, double>>& stages);

/// Prints results to stdout, as one JSON object or as an aligned table.
void print_results(const std::vector<Result>& results, bool json);

/// Prints lines to stdout, made printable. Throws Error(resources) if that fails, and Error(interrupted).
void print(std::string_view lines);

/// Prints a warning to stderr, on one line.
void warn(std::string_view text);

/// A progress bar on stderr, shown until it is destroyed. It is invisible if `quiet`, or if stderr is not a
/// terminal.
class ProgressBar {
 public:
  explicit ProgressBar(bool quiet);
  ~ProgressBar() { clear(); }
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  /// Shows a fraction from 0 to 1. Thread-safe.
  void show(double fraction);
  /// Maps the fractions that follow to a part of the whole. Not while another thread shows one.
  void show_part(double from, double to) { from_ = from, to_ = to; }
  /// Removes the bar from the screen, for example before a warning. The next show() draws it again.
  /// Thread-safe.
  void clear();

 private:
  std::mutex mutex_;
  bool visible_;
  int percent_ = -1;
  double from_ = 0, to_ = 1;
};

}  // namespace boxunion::command
