// Times `measure` by every method on every device, for the same boxes. Each result is first checked against
// that of the cells on the native device. At the end, prints the ratios of the medians to that case.

#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"
#include "host/files/files.hpp"

namespace {

using namespace boxunion;

constexpr std::int64_t kUniverse = 32768;
constexpr std::size_t kMostSlicedCubes =
    1000;  // scattered cubes have a slab at every other coordinate: seconds a run

struct Input {
  std::string name;
  BoxSet boxes;
};

std::vector<Input> inputs() {
  std::vector<Input> all;
  for (const std::uint64_t count : {1'000u, 10'000u})
    for (const double volumes : {0.015, 0.5, 3.0}) {
      const auto edge = std::llround(double(kUniverse) * std::cbrt(volumes / double(count)));
      char name[64];
      std::snprintf(name, sizeof name, "cubes_%d_sum%g", int(count), volumes);
      all.push_back({name, collect(generate_cubes(count, edge, kUniverse, 1))});
    }
  const std::string path = BOXUNION_DATA "/sky130_hd_row.csv";
  if (std::filesystem::exists(path))
    all.push_back({"sky130_hd_row", read_boxes(path)});
  else
    std::fprintf(stderr, "%s is not there and left out; see BOXUNION_DATA\n", path.c_str());
  return all;
}

/// Prints like the console reporter and keeps the medians.
class RatioReporter : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    for (const Run& run : runs)
      if (run.aggregate_name == "median") medians_[run.run_name.function_name] = run.GetAdjustedRealTime();
    ConsoleReporter::ReportRuns(runs);
  }
  /// Prints the ratio of every benchmark to input/cells/native.
  void print_ratios() const {
    std::printf("\n%-48s %s\n", "median", "times cells on native");
    for (const auto& [name, time] : medians_) {
      const auto base = medians_.find(name.substr(0, name.find('/')) + "/cells/native");
      if (base != medians_.end()) std::printf("%-48s %8.2f\n", name.c_str(), time / base->second);
    }
  }

 private:
  std::map<std::string, double> medians_;
};

}  // namespace

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  const std::vector<Input> all = inputs();
  for (const Input& input : all)
    for (const auto& [method, method_name] : {std::pair{Method::cells, "cells"}, {Method::slices, "slices"}})
      for (const DeviceInfo& device : list_devices()) {
        if (method == Method::slices && input.boxes.size() > kMostSlicedCubes &&
            input.name.starts_with("cubes"))
          continue;
        const Options options{.method = method, .device = device.id};
        benchmark::RegisterBenchmark((input.name + "/" + method_name + "/" + device.id).c_str(),
                                     [&input, options](benchmark::State& state) {
                                       const MassProperties expected =
                                           measure(input.boxes, {.device = "native"});
                                       if (measure(input.boxes, options) != expected)
                                         return state.SkipWithError("wrong result");
                                       for (auto _ : state)
                                         benchmark::DoNotOptimize(measure(input.boxes, options));
                                     })
            ->Unit(benchmark::kMillisecond)
            ->UseRealTime()
            ->MinTime(0.05)
            ->Repetitions(5)
            ->ReportAggregatesOnly();
      }
  RatioReporter reporter;
  benchmark::RunSpecifiedBenchmarks(&reporter);
  reporter.print_ratios();
  return 0;
}
