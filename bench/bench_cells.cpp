// The ratios by which the method cells is judged, each against a rival or against itself in the same run.
// Every result is checked before it is timed. Prints Markdown tables. Times are medians, in seconds.

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>

#include "bench/program.hpp"
#include "bench/sorting.hpp"
#include "bench/timing.hpp"
#include "boxunion/generate.hpp"
#include "boxunion/union.hpp"

namespace boxunion {
namespace {

int runs = 5;

double cpu_seconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

/// Cubes of one edge at integer positions in a universe of 32 768.
BoxSet cubes(std::uint64_t count, std::int64_t edge) {
  return collect(generate_cubes(count, edge, 32768, 1));
}

/// The edge of `count` cubes whose volumes add up to `sum` universes.
std::int64_t edge_of(std::uint64_t count, double sum) {
  return std::llround(32768 * std::cbrt(sum / double(count)));
}

/// Fails unless the volume is that of random cubes, within the sampling error.
void check_volume(const MassProperties& mass, std::uint64_t count, std::int64_t edge) {
  const double universe = std::pow(32768.0, 3), v = std::pow(double(edge), 3) / universe;
  const double expected = 1 - std::pow(1 - v, double(count));
  const double slack =
      0.02 * expected + 6 * std::sqrt(v) * expected;  // boxes stay inside, so borders are thinner
  if (std::abs(mass.volume / universe - expected) > slack + 3 * double(edge) / 32768 * expected) {
    throw std::runtime_error(fmt::format("wrong volume {} for {} cubes of edge {}, expected about {}",
                                         mass.volume / universe, count, edge, expected));
  }
}

/// Median wall and CPU seconds of `measure`.
struct Times {
  double wall, cpu;
};
Times time_measure(const BoxSet& boxes, const Options& options, const MassProperties& expected) {
  std::vector<double> wall, cpu;
  for (int r = 0; r <= runs; ++r) {  // the first run warms up: kernels are compiled, memory is touched
    MassProperties mass;
    std::vector<double> calls;
    const double start = cpu_seconds();
    for (double turn = 0; turn < kTurn; turn += calls.back())
      calls.push_back(seconds_of([&] { mass = measure(boxes, options); }));
    const double cpu_of_call = (cpu_seconds() - start) / double(calls.size());
    if (mass != expected) throw std::runtime_error(options.device + " disagrees with native");
    if (r == 0) continue;
    wall.push_back(median(std::move(calls)));
    cpu.push_back(cpu_of_call);
  }
  return {median(wall), median(cpu)};
}

std::vector<std::string> devices() {
  std::vector<std::string> ids;
  for (const DeviceInfo& device : list_devices()) ids.push_back(device.id);
  return ids;
}

void against_sort(Tables& tables) {
  tables.begin("sort", {"cubes", "edge", "sort", "device", "measure", "ratio"});
  for (const auto& [count, edge] : {std::pair{5'000'000, 48}, {20'000'000, 30}}) {
    const BoxSet boxes = cubes(count, edge);
    const MassProperties expected = measure(boxes, {.device = "native"});
    check_volume(expected, count, edge);
    for (const std::string& device : devices()) {
      if (device.starts_with("vulkan") && count > 5'000'000) continue;
      std::vector<double> ours, sorts, ratios;
      for (int r = 0; r <= runs; ++r) {  // in turn, so that both run under the same conditions
        const double sort = seconds_to_sort(boxes);
        MassProperties mass;
        const double time = seconds_of([&] { mass = measure(boxes, {.device = device}); });
        if (mass != expected) std::exit(1);
        if (r == 0) continue;
        sorts.push_back(sort);
        ours.push_back(time);
        ratios.push_back(time / sort);
      }
      tables.add(count, edge, median(sorts), device, median(ours), median(ratios));
    }
  }
}

void scaling(Tables& tables) {
  tables.begin("scaling", {"cubes", "volumes", "measure", "ns_a_box"});
  for (const std::uint64_t count : {10'000, 100'000, 1'000'000, 5'000'000, 20'000'000}) {
    constexpr double kSum = 0.0157;
    const std::int64_t edge = edge_of(count, kSum);
    const BoxSet boxes = cubes(count, edge);
    const MassProperties expected = measure(boxes, {.device = "native"});
    check_volume(expected, count, edge);
    const Times t = time_measure(boxes, {.device = "native"}, expected);
    tables.add(count, kSum, t.wall, 1e9 * t.wall / double(count));
  }
}

void density(Tables& tables) {
  tables.begin("density", {"cubes", "volumes", "measure", "against_sparsest", "vertices"});
  for (const std::uint64_t count : {100'000, 1'000'000}) {
    double sparsest = 0;
    for (const double sum : {0.015, 0.5, 3.0}) {
      const BoxSet boxes = cubes(count, edge_of(count, sum));
      const MassProperties expected = measure(boxes, {.device = "native"});
      check_volume(expected, count, edge_of(count, sum));
      const Times t = time_measure(boxes, {.device = "native"}, expected);
      if (sparsest == 0) sparsest = t.wall;
      tables.add(count, sum, t.wall, t.wall / sparsest, expected.vertices);
    }
  }
}

void threads(Tables& tables) {
  const BoxSet boxes = cubes(5'000'000, 48);
  const MassProperties expected = measure(boxes, {.device = "native"});
  const Times one = time_measure(boxes, {.device = "native", .threads = 1}, expected);
  const Times two = time_measure(boxes, {.device = "native", .threads = 2}, expected);
  tables.begin("threads", {"cubes", "threads", "measure", "speed_up"});
  tables.add(boxes.size(), 1, one.wall, 1.0);
  tables.add(boxes.size(), 2, two.wall, one.wall / two.wall);
}

/// CPU time of the whole run, for the same cells on every device.
void by_device(Tables& tables) {
  tables.begin("devices", {"cubes", "volumes", "device", "cpu", "against_native"});
  for (const double sum : {0.015, 0.5}) {
    const std::uint64_t count = 500'000;
    const BoxSet boxes = cubes(count, edge_of(count, sum));
    const MassProperties expected = measure(boxes, {.device = "native"});
    double native = 0;
    for (const std::string& device : devices()) {
      const Times t = time_measure(boxes, {.device = device}, expected);
      if (native == 0) native = t.cpu;
      tables.add(count, sum, device, t.cpu, t.cpu / native);
    }
  }
}

void kernels(Tables& tables) {
  tables.begin("kernels", {"boxes_a_cell", "occupancy", "faces", "ratio"});
  for (const std::int64_t edge : {300, 600, 1000, 1500}) {
    const BoxSet boxes = cubes(50'000, edge);
    Report report;
    const MassProperties expected = measure(boxes, {.device = "native"}, &report);
    const auto unite_with = [&](CellKernel kernel) {
      std::vector<double> times;
      for (int r = 0; r <= runs; ++r) {
        std::size_t vertices = 0;
        const double t = seconds_of([&] {
          vertices = unite(boxes, {.kernel = kernel, .device = "native", .threads = 1}).vertices.size();
        });
        if (vertices != expected.vertices) std::exit(1);
        if (r > 0) times.push_back(t);
      }
      return median(times);
    };
    const double occupancy = unite_with(CellKernel::occupancy), faces = unite_with(CellKernel::faces);
    tables.add(double(report.cells.items) / double(report.cells.cells), occupancy, faces, faces / occupancy);
  }
}

}  // namespace
}  // namespace boxunion

int main(int argc, char** argv) {
  using namespace boxunion;
  const std::pair<std::string, std::function<void(Tables&)>> sections[] = {
      {"sort", against_sort}, {"scaling", scaling},   {"density", density},
      {"threads", threads},   {"devices", by_device}, {"kernels", kernels}};
  Request all;
  for (const auto& [name, section] : sections) all.sections.push_back(name);
  return run_benchmark(
      argc, argv, "Measures the ratios by which the method cells is judged.", all,
      [&](const Request& request, Tables& tables) {
        runs = request.runs;
        for (const auto& [name, section] : sections)
          if (std::find(request.sections.begin(), request.sections.end(), name) != request.sections.end())
            section(tables);
      });
}
