#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/box.hpp"
#include "core/mass.hpp"
#include "core/solid.hpp"
#include "host/device.hpp"

namespace boxunion {

/// How the union is computed; the result is the same to the last bit.
enum class Method { slices };

/// How kernels are launched; never changes a result. Zero or empty: what suits the device.
struct Tuning {
  std::optional<Shape> shape{};
  std::uint32_t workgroup = 0;
  std::uint32_t tile_coordinates = 0;  ///< slices: distinct coordinates an axis of a tile, at most 31
};

/// What a run is asked to do, beside its boxes.
struct Options {
  Method method = Method::slices;
  std::string device = "auto";  ///< see open_device
  int threads = 0;              ///< threads of the host, 0 for one per core
  Tuning tuning{};

  /// Called now and then, from any thread, with the fraction of the work that is done (0 to 1).
  std::function<void(double)> progress{};
  /// Called with one line for the user, for example when a batch fails on the device and runs natively.
  std::function<void(const std::string&)> warn{};
  /// Where this becomes true the run ends soon with Error(interrupted).
  const std::atomic<bool>* interrupted = nullptr;
};

/// How a run went.
struct Report {
  std::string method;  ///< "slices"
  std::string kernel;  ///< "contour"
  std::string device;  ///< DeviceInfo::id of the device that was used
  /// Seconds by stage in order of work; the last is "total", from boxes in memory to the result.
  std::vector<std::pair<std::string, double>> seconds;
};

/// Mass properties of the union of `boxes`, without ever holding its vertices.
/// Throws Error(input) for invalid boxes, Error(device) where the device cannot be opened.
MassProperties measure(const BoxSet& boxes, const Options& options, Report* report = nullptr);

/// The vertices of the union of `boxes`. Throws as measure does.
Solid unite(const BoxSet& boxes, const Options& options, Report* report = nullptr);

}  // namespace boxunion
