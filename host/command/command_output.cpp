#include "host/command/command_output.hpp"

#include <fmt/format.h>
#include <limits.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <system_error>

#include "boxunion/error.hpp"
#include "core/base/interruptible.hpp"

namespace boxunion::command {

std::string json_number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "null";
}

Result count_result(const std::string& key, std::uint64_t count) {
  return {key, fmt::to_string(count), fmt::to_string(count)};
}

Result number_result(const std::string& key, double value) {
  return {key, json_number(value), fmt::format("{}", value)};
}

Result string_result(const std::string& key, const std::string& text) {
  return {key, json_string(text), printable(text)};
}

Result seconds_result(const std::vector<std::pair<std::string, double>>& stages) {
  std::string json;
  for (const auto& [stage, seconds] : stages)
    json += fmt::format("{}{}: {}", json.empty() ? "" : ", ", json_string(stage), json_number(seconds));
  const double total = stages.empty() ? 0 : stages.back().second;
  return {"seconds", "{" + json + "}", fmt::format("{}", total)};
}

void print_results(const std::vector<Result>& results, bool json) {
  std::string out;
  if (json) {
    for (const Result& result : results)
      out += fmt::format("{}{}: {}", out.empty() ? "{" : ", ", json_string(result.key), result.json);
    out += "}\n";
  } else {
    std::size_t width = 0;
    for (const Result& result : results) width = std::max(width, result.key.size());
    for (const Result& result : results) {
      std::string name = result.key;
      std::replace(name.begin(), name.end(), '_', ' ');
      out += fmt::format("{:{}}  ", name, width);
      for (const char c : result.text) {
        out += c;
        if (c == '\n') out.append(width + 2, ' ');
      }
      out += '\n';
    }
  }
  print(out);
}

void print(std::string_view lines) {
  const std::string shown = printable_lines(lines);
  for (std::string_view rest = shown; !rest.empty();) {
    // A pipe accepts so many bytes as a whole or, if a signal comes first, not at all.
    const ::ssize_t written =
        ::write(STDOUT_FILENO, rest.data(), std::min<std::size_t>(rest.size(), PIPE_BUF));
    if (written >= 0)
      rest.remove_prefix(std::size_t(written));
    else if (errno == EINTR)  // perhaps a signal that asks to stop
      Interruptible::check();
    else
      throw Error(ErrorKind::resources,
                  fmt::format("standard output: cannot write: {}", std::generic_category().message(errno)));
  }
}

void warn(std::string_view text) {
  std::fputs(fmt::format("boxunion: warning: {}\n", printable(text)).c_str(), stderr);
}

ProgressBar::ProgressBar(bool quiet) : visible_(!quiet && ::isatty(STDERR_FILENO)) {}

void ProgressBar::show(double fraction) {
  if (!visible_) return;
  constexpr int kWidth = 40;
  const int percent = int(100 * (from_ + (to_ - from_) * std::clamp(fraction, 0.0, 1.0)));
  const std::scoped_lock lock(mutex_);
  if (percent == percent_) return;
  percent_ = percent;
  const int filled = kWidth * percent / 100;
  std::fputs(fmt::format("\r[{:#>{}}{:.>{}}] {:3}%", "", filled, "", kWidth - filled, percent).c_str(),
             stderr);
  std::fflush(stderr);
}

void ProgressBar::clear() {
  const std::scoped_lock lock(mutex_);
  if (percent_ < 0) return;
  percent_ = -1;
  std::fputs("\r\x1b[K", stderr);
  std::fflush(stderr);
}

}  // namespace boxunion::command
