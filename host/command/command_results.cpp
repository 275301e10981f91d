#include "host/command/command_results.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>

#include "host/tuning/tuning.hpp"

namespace boxunion::command {
namespace {

std::string json_array(const std::array<double, 3>& v) {
  return fmt::format("[{}, {}, {}]", json_number(v[0]), json_number(v[1]), json_number(v[2]));
}

Result vector_result(const std::string& key, const std::array<double, 3>& v) {
  return {key, json_array(v), fmt::format("{}", fmt::join(v, " "))};
}

template <std::size_t N>
Result rows_result(const std::string& key, const std::array<std::array<double, 3>, N>& rows) {
  std::string json, text;
  for (const auto& row : rows) {
    json += (json.empty() ? "[" : ", ") + json_array(row);
    text += fmt::format("{}{}", text.empty() ? "" : "\n", fmt::join(row, " "));
  }
  return {key, json + "]", text};
}

}  // namespace

Options engine_options(const Common& common, ProgressBar& bar) {
  Options options = common.engine;
  options.progress = [&bar](double fraction) { bar.show(fraction); };
  options.warn = [&bar](const std::string& text) {
    bar.clear();
    warn(text);
  };
  options.tuning.tuned = tuned_launches();
  return options;
}

std::shared_ptr<const TunedLaunches> tuned_launches() {
  return read_tuning(tuning_path(), [](const std::string& text) { warn(text); });
}

void add_report(std::vector<Result>& results, const Report& report) {
  results.push_back(string_result("method", report.method));
  results.push_back(string_result("kernel", report.kernel));
  results.push_back(string_result("device", report.device));
  results.push_back(seconds_result(report.seconds));
}

std::vector<Result> mass_results(const MassProperties& mass) {
  return {rows_result("bounds", mass.bounds),       number_result("volume", mass.volume),
          number_result("area", mass.area),         number_result("edge_length", mass.edge_length),
          vector_result("centroid", mass.centroid), rows_result("inertia", mass.inertia),
          count_result("vertices", mass.vertices),  count_result("extreme_vertices", mass.extreme_vertices)};
}

void finish(std::vector<Result>& results, std::optional<std::uint64_t> slabs, const Report& report,
            const Common& common) {
  if (slabs) results.push_back(count_result("slabs", *slabs));
  add_report(results, report);
  print_results(results, common.json);
}

}  // namespace boxunion::command
