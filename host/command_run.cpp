#include "host/command_run.hpp"

#include <fmt/format.h>

#include <string>

namespace boxunion::command {

Options engine_options(const Common& common, ProgressBar& bar) {
  Options options = common.engine;
  options.progress = [&bar](double fraction) { bar.show(fraction); };
  options.warn = [&bar](const std::string& text) {
    bar.clear();
    warn(text);
  };
  options.interrupted = common.interrupted;
  return options;
}

void add_report(std::vector<Result>& results, const Report& report) {
  results.push_back(string_result("method", report.method));
  results.push_back(string_result("kernel", report.kernel));
  results.push_back(string_result("device", report.device));
  std::string json;
  for (const auto& [stage, seconds] : report.seconds)
    json += fmt::format("{}{}: {}", json.empty() ? "" : ", ", json_string(stage), json_number(seconds));
  const double total = report.seconds.empty() ? 0 : report.seconds.back().second;
  results.push_back({"seconds", "{" + json + "}", fmt::format("{}", total)});
}

}  // namespace boxunion::command
