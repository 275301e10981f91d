#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/device/device.hpp"
#include "host/tuning/tuning.hpp"

// Benchmarks of the kernels: every kernel on every device, in every shape, on cells that the product itself
// cuts. Each case is first checked against the result of the native device, and then timed (like
// google/uVkCompute).

namespace boxunion {

/// How full the cells are: cubes at random places whose volumes add up to 0.015, 0.5 or 3 times the space.
enum class Density { sparse, middle, dense };
std::string_view to_string(Density density);

/// The kernels that can be benchmarked, in the order of their cases.
std::span<const std::string_view> benchmark_kernels();

/// The cases to run: all combinations of these.
struct KernelBenchOptions {
  std::vector<std::string> devices{};  ///< ids or kinds, see open_device; empty: all of this machine
  std::vector<std::string> kernels{};  ///< of benchmark_kernels(); empty: all
  std::vector<Density> densities{};    ///< empty: all
  std::vector<std::uint32_t> sizes{};  ///< approximate number of cells (for contour, tiles); empty: by device
  std::vector<Shape> shapes{};         ///< empty: the one in use
  std::vector<std::uint32_t> workgroups{};       ///< empty: the one in use
  bool every_launch = false;                     ///< empty shapes and workgroups mean all that may be fast
  std::uint32_t repetitions = 9;                 ///< timed runs of a case, at least 1
  std::shared_ptr<const TunedLaunches> tuned{};  ///< launches to use instead of the device's defaults
};

/// The times of one run of a case. Wall time is from the batch in host memory to the result in host memory.
struct BenchRun {
  double device_seconds = 0;  ///< in the kernel; natively, CPU seconds of all threads
  double wall_seconds = 0;
  double cpu_seconds = 0;  ///< of this process, including the driver of a CPU device
};

/// A median and the spread of the values around it.
struct Spread {
  double median = 0;
  double deviation = 0;  ///< half the distance between the quartiles
};
/// Of at least one value.
Spread spread_of(std::vector<double> values);

/// A device, and the yardsticks for its times.
struct BenchDevice {
  DeviceInfo info;
  Spread dispatch_seconds;       ///< wall time of an empty dispatch, including the wait for it
  Spread copy_seconds;           ///< device time of a copy
  std::uint64_t copy_bytes = 0;  ///< bytes read and written by that copy
  std::string error;             ///< the reason if it has no results
  double copy_bytes_per_second() const { return double(copy_bytes) / copy_seconds.median; }
};

/// A case and its results.
struct BenchCase {
  std::string device{}, kernel{};  ///< id and name
  Density density = Density::middle;
  std::uint32_t size = 0;  ///< requested number of cells
  Launch launch{};
  std::uint64_t cells = 0, boxes = 0, vertices = 0;  ///< boxes: a box in two cells counts twice
  std::uint64_t bytes_read = 0, bytes_written = 0;   ///< of device memory, each array once
  double first_seconds = 0;  ///< wall time of loading the kernel and of the first run, with its compilation
  std::vector<BenchRun> runs{};
  std::string error{};  ///< the reason if it was skipped; then there are no runs

  Spread of(double BenchRun::*seconds) const;
  /// "device/kernel/shape/workgroup/density/size".
  std::string name() const;
};

struct BenchResults {
  std::vector<BenchDevice> devices;
  std::vector<BenchCase> cases;
  const BenchDevice& device(std::string_view id) const;
};

/// Runs the cases, device by device. A device or a case that fails is skipped, and its result says why. A
/// missing device is an Error(device). Calls `done` with every finished case and its device. Throws
/// Error(usage) for an unknown kernel, and Error(interrupted).
BenchResults run_kernel_bench(const KernelBenchOptions& options,
                              const std::function<void(const BenchDevice&, const BenchCase&)>& done);

/// The best launch of a kernel on a device.
struct BestLaunch {
  DeviceInfo device;
  std::string kernel;
  Launch launch;
  double gain = 1;  ///< device time of the launch in use divided by that of this one
};

/// For each kernel and each device except native, the launch with the least device time, by the geometric
/// mean over its cases. Launches that lack a case of another launch are left out. The launch in use stays,
/// unless another one is better by more than the noise of both.
std::vector<BestLaunch> best_launches(const BenchResults& results,
                                      const std::shared_ptr<const TunedLaunches>& in_use);

}  // namespace boxunion
