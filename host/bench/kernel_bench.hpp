#pragma once

#include <atomic>
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
// cuts. Each case first checks its output against the native device's, then is timed (google/uVkCompute).

namespace boxunion {

/// How full the cells are: cubes at random places whose volumes add up to 0.015, 0.5 or 3 times the space.
enum class Density { sparse, middle, dense };
std::string_view to_string(Density density);

/// The kernels that can be benchmarked, in the order of their cases.
std::span<const std::string_view> benchmark_kernels();

/// Which cases to run: all combinations.
struct KernelBenchOptions {
  std::vector<std::string> devices{};       ///< ids or kinds, see open_device; empty: all of this machine
  std::vector<std::string> kernels{};       ///< of benchmark_kernels(); empty: all
  std::vector<Density> densities{};         ///< empty: all
  std::vector<std::uint32_t> sizes{};       ///< cells (of contour: tiles), about; empty: by device
  std::vector<Shape> shapes{};              ///< empty: the one in use
  std::vector<std::uint32_t> workgroups{};  ///< empty: the one in use
  bool every_launch = false;                ///< shapes and workgroups that are empty: all that may be fast
  std::uint32_t repetitions = 9;            ///< timed runs of a case, at least 1
  std::shared_ptr<const TunedLaunches> tuned{};  ///< what is in use where it is not the device's default
  const std::atomic<bool>* interrupted = nullptr;
};

/// What one run of a case took. Wall time is from batch in host memory to result in host memory.
struct BenchRun {
  double device_seconds = 0;  ///< in the kernel; natively, CPU seconds of all threads
  double wall_seconds = 0;
  double cpu_seconds = 0;  ///< of this process, a CPU device's driver included
};

/// A middle value and how far the others lie from it.
struct Spread {
  double median = 0;
  double deviation = 0;  ///< half the distance of the quartiles
};
/// Of at least one value.
Spread spread_of(std::vector<double> values);

/// A device, and what its times are to be compared with.
struct BenchDevice {
  DeviceInfo info;
  Spread dispatch_seconds;       ///< wall time of a dispatch that does nothing, and of waiting for it
  Spread copy_seconds;           ///< device time of a copy
  std::uint64_t copy_bytes = 0;  ///< read and written by that copy
  std::string error;             ///< why it has no results, if it has none
  double copy_bytes_per_second() const { return double(copy_bytes) / copy_seconds.median; }
};

/// A case and how it went.
struct BenchCase {
  std::string device{}, kernel{};  ///< id and name
  Density density = Density::middle;
  std::uint32_t size = 0;  ///< cells that were asked for
  Launch launch{};
  std::uint64_t cells = 0, boxes = 0, vertices = 0;  ///< boxes: in cells, one in two cells counts twice
  std::uint64_t bytes_read = 0, bytes_written = 0;   ///< of device memory, each array once
  double first_seconds = 0;  ///< wall time of loading the kernel and of its first run, where it is compiled
  std::vector<BenchRun> runs{};
  std::string error{};  ///< why it was skipped: then there are no runs

  Spread of(double BenchRun::*seconds) const;
  /// "device/kernel/shape/workgroup/density/size".
  std::string name() const;
};

struct BenchResults {
  std::vector<BenchDevice> devices;
  std::vector<BenchCase> cases;
  const BenchDevice& device(std::string_view id) const;
};

/// Runs the cases, device by device. A device or a case that fails says so in its result and is skipped;
/// a device that is not there is an Error(device). `done` gets every case when it has ended, with its device.
/// Throws Error(usage) for a kernel that there is not, Error(interrupted).
BenchResults run_kernel_bench(const KernelBenchOptions& options,
                              const std::function<void(const BenchDevice&, const BenchCase&)>& done);

/// The launch that proved best for a kernel on a device.
struct BestLaunch {
  DeviceInfo device;
  std::string kernel;
  Launch launch;
  double gain = 1;  ///< device time of the launch in use / of this one
};

/// Of each device other than native and each kernel, the launch with the least device time, as the geometric
/// mean of its cases; launches that lack a case which another one has are left out. What is in use stays
/// unless another launch is better by more than the noise of both.
std::vector<BestLaunch> best_launches(const BenchResults& results,
                                      const std::shared_ptr<const TunedLaunches>& in_use);

}  // namespace boxunion
