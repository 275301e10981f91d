#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "boxunion/error.hpp"
#include "host/bench/bench_json.hpp"
#include "host/bench/kernel_bench.hpp"
#include "host/command/command.hpp"
#include "host/command/command_results.hpp"
#include "host/engine/threads.hpp"
#include "host/tuning/tuning.hpp"

namespace boxunion::command {
namespace {

/// Seconds with a unit, of the width of a column.
std::string time_text(double seconds) {
  if (seconds < 1e-3) return fmt::format("{:6.1f} us", 1e6 * seconds);
  if (seconds < 1) return fmt::format("{:6.2f} ms", 1e3 * seconds);
  return fmt::format("{:6.2f} s ", seconds);
}

std::string time_text(const Spread& seconds) {
  const double percent = seconds.median > 0 ? 100 * seconds.deviation / seconds.median : 0;
  return fmt::format("{} +-{:3.0f}%", time_text(seconds.median), percent);
}

constexpr const char* kHeader =
    "kernel               shape  group  density   cells          device time            wall time  first run"
    "  Mcells/s  Mboxes/s  Mvert/s    GB/s  of copy\n";

std::string device_text(const BenchDevice& device) {
  return fmt::format("\n{}: {} ({})\n{}\nempty dispatch {}, copy {:.2f} GB/s\n\n{}", device.info.id,
                     device.info.name, device.info.is_cpu ? "CPU" : "GPU", device.info.driver,
                     time_text(device.dispatch_seconds), 1e-9 * device.copy_bytes_per_second(), kHeader);
}

std::string case_text(const BenchDevice& device, const BenchCase& c) {
  std::string text = fmt::format("{:19}  {:5}  {:5}  {:7}  {:6}  ", c.kernel, to_string(c.launch.shape),
                                 c.launch.workgroup, to_string(c.density), c.cells);
  if (!c.error.empty()) return text + "skipped: " + c.error + "\n";
  const Spread seconds = c.of(&BenchRun::device_seconds);
  text += fmt::format("{:>18}  {:>18}  {}", time_text(seconds), time_text(c.of(&BenchRun::wall_seconds)),
                      time_text(c.first_seconds));
  if (seconds.median > 0) {
    const auto rate = [&](std::uint64_t count) { return double(count) / seconds.median; };
    const double bytes = rate(c.bytes_read + c.bytes_written);
    text += fmt::format("  {:8.2f}  {:8.2f}  {:7.2f}  {:6.2f}  {:6.1f}%", 1e-6 * rate(c.cells),
                        1e-6 * rate(c.boxes), 1e-6 * rate(c.vertices), 1e-9 * bytes,
                        100 * bytes / device.copy_bytes_per_second());
  }
  return text + "\n";
}

void compare(const std::string& before, const std::string& after) {
  std::vector<BenchChange> changes = compare_bench_json(before, after);
  std::size_t width = 4;
  for (BenchChange& change : changes) {
    change.name = printable(change.name);
    width = std::max(width, change.name.size());
  }
  std::string out =
      fmt::format("{:{}}  {:>9}  {:>9}  {:>8}  {:>6}\n", "case", width, "before", "after", "change", "noise");
  for (const BenchChange& c : changes) {
    if (!c.before || !c.after) {
      out += fmt::format("{:{}}  only in {}\n", c.name, width, printable(c.before ? before : after));
      continue;
    }
    const double change = c.change(), noise = c.noise();
    out += fmt::format("{:{}}  {}  {}  {:+7.1f}%  {:5.1f}%  {}\n", c.name, width, time_text(c.before->median),
                       time_text(c.after->median), 100 * change, 100 * noise,
                       !(std::abs(change) > noise) ? "same"
                       : change < 0                ? "faster"
                                                   : "slower");
  }
  print(out);
}

/// Writes the best launches to a tuning file. Its entries for other devices are kept.
void tune(const BenchResults& results, const std::shared_ptr<const TunedLaunches>& in_use,
          const std::string& path, OutputFile file) {
  const std::vector<BestLaunch> best = best_launches(results, in_use);
  if (best.empty()) {
    print("\nnothing to tune: no device but native has results\n");
    return;
  }
  TunedLaunches launches = TunedLaunches::read(path, [](const std::string& text) { warn(text); });
  std::string out = "\nbest launches\n";
  for (const BestLaunch& b : best) {
    launches.set(b.device, b.kernel, b.launch);
    out += fmt::format("{:10}  {:19}  {:5}  {:4}  {}\n", b.device.id, b.kernel, to_string(b.launch.shape),
                       b.launch.workgroup,
                       b.gain > 1 ? fmt::format("{:.2f} times as fast as before", b.gain) : "as before");
  }
  launches.write(std::move(file));
  print(out + fmt::format("tuning file: {}\n", printable(path)));
}

}  // namespace

void bench(const BenchOptions& bench_options, const Common& common) {
  if (!bench_options.compare.empty())
    return compare(bench_options.compare.at(0), bench_options.compare.at(1));
  KernelBenchOptions options = bench_options.cases;
  options.tuned = tuned_launches();
  options.every_launch = bench_options.tune.has_value();
  if (bench_options.quick) {
    if (options.densities.empty()) options.densities = {Density::middle};
    if (options.sizes.empty()) options.sizes = {1024};
    options.repetitions = std::min(options.repetitions, 5u);
  }
  std::string tuning_file;
  if (bench_options.tune) {
    tuning_file = bench_options.tune->empty() ? tuning_path() : *bench_options.tune;
    if (tuning_file.empty())
      throw Error(ErrorKind::usage, "--tune: the tuning file has no default path here: name a file");
  }
  OutputGroup outputs;
  std::optional<OutputFile> json, tuning;
  if (bench_options.tune) tuning.emplace(open_tuning_file(tuning_file, &outputs));
  if (!bench_options.json.empty()) json.emplace(bench_options.json, &outputs);

  std::string last_device;
  const BenchResults results = with_threads(common.engine, [&] {
    return run_kernel_bench(options, [&](const BenchDevice& device, const BenchCase& c) {
      if (!device.error.empty()) return warn(fmt::format("{} is skipped: {}", device.info.id, device.error));
      if (last_device != device.info.id) print(device_text(device));
      last_device = device.info.id;
      print(case_text(device, c));
    });
  });
  if (json) write_bench_json(results, std::move(*json));
  if (tuning) tune(results, options.tuned, tuning_file, std::move(*tuning));
  outputs.publish();
}

}  // namespace boxunion::command
