#include "host/bench/bench_json.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "boxunion/error.hpp"
#include "host/files/input.hpp"

namespace boxunion {
namespace {

using Json = nlohmann::ordered_json;

Json describe(const BenchDevice& device) {
  const DeviceInfo& info = device.info;
  Json json = {{"id", info.id}, {"name", info.name}, {"driver", info.driver}, {"cpu", info.is_cpu}};
  if (!device.error.empty()) {
    json["error"] = device.error;
    return json;
  }
  json["dispatch_seconds"] = device.dispatch_seconds.median;
  json["copy_bytes_per_second"] = device.copy_bytes_per_second();
  return json;
}

Json context(const BenchResults& results) {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  std::array<double, 3> load{};
  ::getloadavg(load.data(), 3);
  Json json = {{"date", fmt::format("{:%Y-%m-%dT%H:%M:%S}+00:00", fmt::gmtime(std::time(nullptr)))},
               {"host_name", host.data()},
               {"executable", "boxunion bench"},
               {"num_cpus", std::thread::hardware_concurrency()},
               {"mhz_per_cpu", 0},
               {"caches", Json::array()},
               {"load_avg", load},
#ifdef NDEBUG
               {"library_build_type", "release"},
#else
               {"library_build_type", "debug"},
#endif
               {"devices", Json::array()}};
  for (const BenchDevice& device : results.devices) json["devices"].push_back(describe(device));
  return json;
}

/// The members that all entries of a case begin with.
Json head(const BenchCase& c, const std::string& suffix, const char* type) {
  return {{"name", c.name() + suffix},
          {"run_name", c.name()},
          {"run_type", type},
          {"repetitions", c.runs.size()},
          {"threads", 1}};
}

/// Adds the times and counters of a run. `copy_rate` is in bytes per second.
void add_times(Json& entry, const BenchCase& c, const BenchRun& run, double copy_rate) {
  entry["real_time"] = 1e9 * run.wall_seconds;
  entry["cpu_time"] = 1e9 * run.cpu_seconds;
  entry["time_unit"] = "ns";
  entry["device_seconds"] = run.device_seconds;
  if (run.device_seconds <= 0) return;
  const auto rate = [&](std::uint64_t count) { return double(count) / run.device_seconds; };
  entry["cells_per_second"] = rate(c.cells);
  entry["boxes_per_second"] = rate(c.boxes);
  entry["vertices_per_second"] = rate(c.vertices);
  entry["bytes_per_second"] = rate(c.bytes_read + c.bytes_written);
  entry["copy_bandwidth_fraction"] = rate(c.bytes_read + c.bytes_written) / copy_rate;
}

void add_case(Json& entries, const BenchCase& c, double copy_rate) {
  const auto add_facts = [&](Json& entry) {
    entry["cells"] = c.cells;
    entry["boxes"] = c.boxes;
    entry["vertices"] = c.vertices;
    entry["bytes_read"] = c.bytes_read;
    entry["bytes_written"] = c.bytes_written;
    entry["first_run_seconds"] = c.first_seconds;
  };
  for (std::size_t i = 0; i < c.runs.size(); ++i) {
    Json& entry = entries.emplace_back(head(c, "", "iteration"));
    entry["repetition_index"] = i;
    entry["iterations"] = 1;
    add_times(entry, c, c.runs[i], copy_rate);
    add_facts(entry);
  }
  const auto of_times = [&](const auto& f) {
    return BenchRun{f(&BenchRun::device_seconds), f(&BenchRun::wall_seconds), f(&BenchRun::cpu_seconds)};
  };
  const BenchRun median = of_times([&](double BenchRun::*t) { return c.of(t).median; });
  const BenchRun stddev = of_times([&](double BenchRun::*t) {
    double sum = 0, squares = 0;
    for (const BenchRun& run : c.runs) sum += run.*t;
    const double mean = sum / double(c.runs.size());
    for (const BenchRun& run : c.runs) squares += (run.*t - mean) * (run.*t - mean);
    return c.runs.size() > 1 ? std::sqrt(squares / double(c.runs.size() - 1)) : 0.0;
  });
  Json& middle = entries.emplace_back(head(c, "_median", "aggregate"));
  middle["aggregate_name"] = "median";
  middle["aggregate_unit"] = "time";
  middle["iterations"] = c.runs.size();
  add_times(middle, c, median, copy_rate);
  add_facts(middle);
  Json& deviation = entries.emplace_back(head(c, "_stddev", "aggregate"));
  deviation["aggregate_name"] = "stddev";
  deviation["aggregate_unit"] = "time";
  deviation["iterations"] = c.runs.size();
  deviation["real_time"] = 1e9 * stddev.wall_seconds;
  deviation["cpu_time"] = 1e9 * stddev.cpu_seconds;
  deviation["time_unit"] = "ns";
  deviation["device_seconds"] = stddev.device_seconds;
}

/// The times of each case of a file.
struct Times {
  std::vector<double> device, wall;
};
struct Results {
  std::vector<std::string> names;  // in order of appearance
  std::map<std::string, Times> times;
};

double seconds_a_unit(const std::string& unit) {
  return unit == "s" ? 1 : unit == "ms" ? 1e-3 : unit == "us" ? 1e-6 : 1e-9;
}

Results read_results(const std::string& path) {
  constexpr std::size_t kMostBytes = std::size_t{1} << 26;
  const std::string text = InputFile(path).read_all(kMostBytes);
  Results results;
  try {
    const Json root = Json::parse(text);
    for (const Json& entry : root.at("benchmarks")) {
      if (entry.value("run_type", "iteration") != "iteration" || entry.value("error_occurred", false))
        continue;
      const std::string name = entry.contains("run_name") ? entry.at("run_name") : entry.at("name");
      const auto [at, is_new] = results.times.try_emplace(name);
      if (is_new) results.names.push_back(name);
      const double unit = seconds_a_unit(entry.value("time_unit", "ns"));
      at->second.wall.push_back(unit * entry.at("real_time").get<double>());
      if (entry.contains("device_seconds")) at->second.device.push_back(entry.at("device_seconds"));
    }
  } catch (const Json::exception& error) {
    throw Error(ErrorKind::input,
                fmt::format("{}: not results of a benchmark, expected Google Benchmark's JSON: {}", path,
                            error.what()));
  }
  return results;
}

}  // namespace

void write_bench_json(const BenchResults& results, OutputFile file) {
  Json entries = Json::array();
  std::size_t index = 0;
  for (const BenchCase& c : results.cases) {
    const std::size_t first = entries.size();
    if (c.error.empty()) {
      add_case(entries, c, results.device(c.device).copy_bytes_per_second());
    } else {
      Json& entry = entries.emplace_back(head(c, "", "iteration"));
      entry["error_occurred"] = true;
      entry["error_message"] = c.error;
    }
    for (std::size_t i = first; i < entries.size(); ++i) {
      entries[i]["family_index"] = index;
      entries[i]["per_family_instance_index"] = 0;
    }
    ++index;
  }
  const Json root = {{"context", context(results)}, {"benchmarks", std::move(entries)}};
  file.write(root.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  file.commit();
}

double BenchChange::noise() const {
  return std::hypot(before->deviation / before->median, after->deviation / after->median) * after->median /
         before->median;
}

std::vector<BenchChange> compare_bench_json(const std::string& before, const std::string& after) {
  Results old_results = read_results(before), new_results = read_results(after);
  std::vector<BenchChange> changes;
  for (const std::string& name : old_results.names) {
    const Times& old_times = old_results.times[name];
    const auto found = new_results.times.find(name);
    if (found == new_results.times.end()) {
      changes.push_back({name, spread_of(old_times.wall), {}});
      continue;
    }
    const bool device = !old_times.device.empty() && !found->second.device.empty();
    const auto spread = [&](const Times& times) { return spread_of(device ? times.device : times.wall); };
    changes.push_back({name, spread(old_times), spread(found->second)});
  }
  for (const std::string& name : new_results.names)
    if (!old_results.times.contains(name))
      changes.push_back({name, {}, spread_of(new_results.times[name].wall)});
  return changes;
}

}  // namespace boxunion
