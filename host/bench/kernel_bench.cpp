#include "host/bench/kernel_bench.hpp"

#include <fmt/format.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <new>
#include <numeric>
#include <tuple>
#include <utility>

#include "boxunion/error.hpp"
#include "core/base/interruptible.hpp"
#include "host/bench/bench_problem.hpp"
#include "host/device/backend.hpp"
#include "host/device/kernels.hpp"
#include "kernels/contract.h"

namespace boxunion {
namespace {

/// Wall and CPU seconds of this process, and seconds of the device.
struct Clocks {
  explicit Clocks(const Device& device)
      : wall(std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count()),
        device(device.kernel_seconds()) {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    cpu = double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
  }
  double wall, device, cpu = 0;
};

/// Runs f, which waits for the device, and returns its times.
template <class F>
BenchRun timed(const Device& device, F&& f) {
  const Clocks before(device);
  f();
  const Clocks after(device);
  return {after.device - before.device, after.wall - before.wall, after.cpu - before.cpu};
}

std::vector<double> values_of(std::span<const BenchRun> runs, double BenchRun::*seconds) {
  std::vector<double> values;
  for (const BenchRun& run : runs) values.push_back(run.*seconds);
  return values;
}

/// Calls f and returns the error of the device, if there was one.
template <class F>
std::string error_of(F&& f) {
  try {
    f();
    return {};
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::device && error.kind() != ErrorKind::resources) throw;
    return error.what();
  } catch (const std::bad_alloc&) {
    return "out of memory";
  }
}

/// Measures an empty dispatch and a copy of an array.
void measure_yardsticks(Device& device, const Tuning& tuning, std::uint32_t repetitions,
                        BenchDevice& result) {
  const DeviceInfo& info = device.info();
  const std::size_t bytes =
      std::min<std::size_t>(info.max_buffer_bytes, std::size_t{1} << (info.is_cpu ? 25 : 28));
  const auto words = std::uint32_t(bytes / sizeof(std::uint64_t));
  const auto kernel = load(device, kernels::copy(), tuning);
  const auto from = device.allocate(bytes), to = device.allocate(bytes);
  const auto values = from->view<std::uint64_t>();
  std::iota(values.begin(), values.end(), std::uint64_t{1} << 40);
  device.upload(*from, bytes);
  const auto copy = [&](std::uint32_t count) {
    Buffer* const buffers[] = {from.get(), to.get()};
    device.dispatch(*kernel, buffers, std::as_bytes(std::span(&count, 1)),
                    std::max(1u, (count + COPY_CHUNK - 1) / COPY_CHUNK));
    device.wait();
  };
  copy(words);
  device.download(*to, 0, bytes);
  device.wait();
  if (!std::ranges::equal(to->view<std::uint64_t>(), from->view<std::uint64_t>()))
    throw Error(ErrorKind::device, info.id + ": the kernel copy gave a wrong result");
  std::vector<BenchRun> copies, empty;
  for (std::uint32_t r = 0; r < repetitions; ++r) copies.push_back(timed(device, [&] { copy(words); }));
  for (std::uint32_t r = 0; r < 4 * repetitions; ++r) empty.push_back(timed(device, [&] { copy(0); }));
  result.copy_bytes = 2 * std::uint64_t{words} * sizeof(std::uint64_t);
  result.copy_seconds = spread_of(values_of(copies, &BenchRun::device_seconds));
  result.dispatch_seconds = spread_of(values_of(empty, &BenchRun::wall_seconds));
}

/// The launches of a kernel that the options select.
std::vector<Launch> launches_of(const DeviceInfo& info, std::string_view kernel,
                                const KernelBenchOptions& options) {
  std::vector<Launch> launches;
  const auto add = [&](std::optional<Shape> shape, std::uint32_t workgroup) {
    const Launch launch =
        choose_launch(info, kernel, {.shape = shape, .workgroup = workgroup, .tuned = options.tuned});
    if (std::ranges::find(launches, launch) == launches.end()) launches.push_back(launch);
  };
  if (info.id == "native") {  // it has neither shapes nor workgroups
    launches.push_back({});
    return launches;
  }
  std::vector<std::optional<Shape>> shapes(options.shapes.begin(), options.shapes.end());
  std::vector<std::uint32_t> workgroups = options.workgroups;
  if (options.every_launch) {
    add({}, 0);
    // on a CPU, the lanes of a group are a loop with barriers, which is never faster
    if (shapes.empty() && info.is_cpu) shapes = {Shape::item};
    if (shapes.empty()) shapes = {Shape::group, Shape::item};
    if (workgroups.empty() && info.is_cpu) workgroups = {1, 4, 8, 16, 32, 64};
    if (workgroups.empty()) workgroups = {32, 64, 128};
  }
  if (shapes.empty()) shapes = {std::nullopt};
  if (workgroups.empty()) workgroups = {0};
  for (const std::optional<Shape> shape : shapes)
    for (const std::uint32_t workgroup : workgroups) add(shape, workgroup);
  return launches;
}

/// Checks a case and times it.
void run_case(Device& device, const BenchProblem& problem, std::uint32_t repetitions, BenchCase& result) {
  const Tuning tuning{.shape = result.launch.shape, .workgroup = result.launch.workgroup};
  std::unique_ptr<BenchRunner> runner;
  bool right = false;
  result.first_seconds = timed(device, [&] {
                           runner = problem.make_runner(device, tuning);
                           right = runner->check();
                         }).wall_seconds;
  if (!right) throw Error(ErrorKind::device, "wrong result: it differs from the native device's");
  if (runner->ran_natively())
    throw Error(ErrorKind::device, "the device cuts long loops short: the cells ran natively");
  std::vector<BenchRun> runs;
  for (std::uint32_t r = 0; r < repetitions; ++r) runs.push_back(timed(device, [&] { runner->run(); }));
  result.runs = std::move(runs);
}

class Bench {
 public:
  Bench(const KernelBenchOptions& options,
        const std::function<void(const BenchDevice&, const BenchCase&)>& done)
      : options_(options), done_(done) {
    for (const std::string& kernel : options.kernels)
      if (std::ranges::find(benchmark_kernels(), kernel) == benchmark_kernels().end())
        throw Error(ErrorKind::usage, fmt::format("no kernel '{}'", kernel));
    kernels_ = options.kernels;
    if (kernels_.empty()) kernels_.assign(benchmark_kernels().begin(), benchmark_kernels().end());
    densities_ = options.densities;
    if (densities_.empty()) densities_ = {Density::sparse, Density::middle, Density::dense};
  }

  BenchResults run() {
    for (const DeviceInfo& info : devices()) run_device(info);
    return std::move(results_);
  }

 private:
  std::vector<DeviceInfo> devices() const {
    std::vector<DeviceInfo> all = list_devices();
    if (options_.devices.empty()) return all;
    std::vector<DeviceInfo> chosen;
    for (const std::string& id : options_.devices) {
      const auto found = std::ranges::find_if(
          all, [&](const DeviceInfo& info) { return info.id == id || info.id == id + ":0"; });
      chosen.push_back(found != all.end() ? *found : open_device(id)->info());  // auto, or it throws
    }
    return chosen;
  }

  void run_device(const DeviceInfo& info) {
    BenchDevice& device = results_.devices.emplace_back();
    device.info = info;
    const Tuning tuning{.tuned = options_.tuned};
    std::unique_ptr<Device> opened;
    device.error = error_of([&] {
      opened = open_device(info.id);
      measure_yardsticks(*opened, tuning, options_.repetitions, device);
    });
    if (!device.error.empty()) return done_(device, {.device = info.id, .error = device.error});
    std::vector<std::uint32_t> sizes = options_.sizes;
    if (sizes.empty()) sizes = {info.is_cpu ? 4096u : 65536u};
    for (const std::string& kernel : kernels_)
      for (const Density density : densities_)
        for (const std::uint32_t size : sizes)
          for (const Launch& launch : launches_of(info, kernel, options_)) {
            Interruptible::check();
            const BenchProblem& problem = find_problem(kernel, density, size);
            BenchCase& result = results_.cases.emplace_back(problem.describe());
            result.device = info.id;
            result.density = density;
            result.size = size;
            result.launch = launch;
            result.error = error_of([&] {
              if (!opened) opened = open_device(info.id);
              run_case(*opened, problem, options_.repetitions, result);
            });
            if (!result.error.empty()) opened.reset();  // a device that failed may give no more results
            done_(device, result);
          }
  }

  const BenchProblem& find_problem(const std::string& kernel, Density density, std::uint32_t size) {
    std::unique_ptr<BenchProblem>& problem = problems_[{kernel, density, size}];
    if (!problem) problem = make_problem(kernel, density, size);
    return *problem;
  }

  const KernelBenchOptions& options_;
  const std::function<void(const BenchDevice&, const BenchCase&)>& done_;
  std::vector<std::string> kernels_;
  std::vector<Density> densities_;
  std::map<std::tuple<std::string, Density, std::uint32_t>, std::unique_ptr<BenchProblem>> problems_;
  BenchResults results_;
};

}  // namespace

std::string_view to_string(Density density) {
  return density == Density::sparse ? "sparse" : density == Density::middle ? "middle" : "dense";
}

Spread spread_of(std::vector<double> values) {
  std::ranges::sort(values);
  const auto quantile = [&](double q) {
    const double at = q * double(values.size() - 1);
    const auto below = std::size_t(at);
    const std::size_t above = std::min(below + 1, values.size() - 1);
    return std::lerp(values[below], values[above], at - double(below));
  };
  return {quantile(0.5), (quantile(0.75) - quantile(0.25)) / 2};
}

Spread BenchCase::of(double BenchRun::*seconds) const {
  return spread_of(values_of(runs, seconds));
}

std::string BenchCase::name() const {
  return fmt::format("{}/{}/{}/{}/{}/{}", device, kernel, to_string(launch.shape), launch.workgroup,
                     to_string(density), size);
}

const BenchDevice& BenchResults::device(std::string_view id) const {
  return *std::ranges::find_if(devices, [&](const BenchDevice& device) { return device.info.id == id; });
}

BenchResults run_kernel_bench(const KernelBenchOptions& options,
                              const std::function<void(const BenchDevice&, const BenchCase&)>& done) {
  return Bench(options, done).run();
}

std::vector<BestLaunch> best_launches(const BenchResults& results,
                                      const std::shared_ptr<const TunedLaunches>& in_use) {
  using Problem = std::pair<Density, std::uint32_t>;
  struct Candidate {
    Launch launch;
    std::map<Problem, Spread> seconds;

    double noise() const {
      double sum = 0;
      for (const auto& [problem, spread] : seconds) sum += spread.deviation / spread.median;
      return sum / double(seconds.size());
    }
    double mean() const {
      double sum = 0;
      for (const auto& [problem, spread] : seconds) sum += std::log(spread.median);
      return std::exp(sum / double(seconds.size()));
    }
  };
  std::map<std::pair<std::string, std::string>, std::vector<Candidate>> by_kernel;
  for (const BenchCase& result : results.cases) {
    if (result.runs.empty() || result.device == "native") continue;
    const Spread spread = result.of(&BenchRun::device_seconds);
    if (spread.median <= 0) continue;  // the device does not measure times
    std::vector<Candidate>& candidates = by_kernel[{result.device, result.kernel}];
    auto candidate = std::ranges::find(candidates, result.launch, &Candidate::launch);
    if (candidate == candidates.end()) candidate = candidates.insert(candidate, {result.launch, {}});
    candidate->seconds[{result.density, result.size}] = spread;
  }
  std::vector<BestLaunch> best;
  for (auto& [key, candidates] : by_kernel) {
    std::size_t most = 0;
    for (const Candidate& c : candidates) most = std::max(most, c.seconds.size());
    std::erase_if(candidates, [&](const Candidate& c) { return c.seconds.size() < most; });
    const DeviceInfo& info = results.device(key.first).info;
    const Candidate* choice = &*std::ranges::min_element(candidates, {}, &Candidate::mean);
    const auto current =
        std::ranges::find(candidates, choose_launch(info, key.second, {.tuned = in_use}), &Candidate::launch);
    double gain = 1;
    if (current != candidates.end()) {
      gain = current->mean() / choice->mean();
      if (gain < 1 + choice->noise() + current->noise()) choice = &*current, gain = 1;
    }
    best.push_back({info, key.second, choice->launch, gain});
  }
  return best;
}

}  // namespace boxunion
