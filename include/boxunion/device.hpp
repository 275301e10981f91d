#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "boxunion/export.hpp"

namespace boxunion {

/// How a kernel shares its work. GROUP gives a workgroup to each work unit (GPUs), ITEM a work-item (CPU
/// devices). The native device is always serial within a unit.
enum class Shape { group, item };

/// The properties of a device.
struct DeviceInfo {
  std::string id;          ///< "native", "opencl:0", "vulkan:1": what --device takes
  std::string name;        ///< the device's own name
  std::string driver;      ///< platform and version
  bool is_cpu = true;      ///< shares the host's cores
  bool is_unified = true;  ///< works on host memory: uploads and downloads copy nothing
  std::size_t max_buffer_bytes = 0;
  std::uint32_t max_workgroup = 1;
  std::uint64_t memory_bytes = 0;
  Shape preferred_shape = Shape::item;
  std::uint32_t preferred_workgroup = 1;
};

/// The devices of this machine, native first, then OpenCL, then Vulkan. A back end that is not built in or
/// finds no driver has none; `notes`, if given, gets a line that says so.
BOXUNION_API std::vector<DeviceInfo> list_devices(std::vector<std::string>* notes = nullptr);

class TunedLaunches;

/// How kernels are launched. Never changes a result. Zero or empty: what suits the device.
struct Tuning {
  std::optional<Shape> shape{};
  std::uint32_t workgroup = 0;
  std::uint32_t tile_coordinates = 0;  ///< slices: distinct coordinates on each axis of a tile, at most 31
  std::uint32_t cell = 0;              ///< cells: edge in ordinals, rounded up to a power of two
  std::uint32_t cell_boxes = 0;        ///< cells: boxes above which a cell is cut again
  /// The best launches on some devices (read_tuning), used if shape and workgroup are not given.
  std::shared_ptr<const TunedLaunches> tuned{};
};

/// The path of this user's tuning file: BOXUNION_TUNING if it is set (empty: no file), otherwise
/// boxunion/tuning.json in $XDG_CONFIG_HOME or ~/.config. Empty if there is none.
BOXUNION_API std::string tuning_path();

/// Reads a tuning file, for Tuning::tuned. A missing file has no launches. A file that cannot be read or is
/// not a tuning file has none either, and invalid entries are left out; `warn` then gets a line for each.
BOXUNION_API std::shared_ptr<const TunedLaunches> read_tuning(
    const std::string& path, const std::function<void(const std::string&)>& warn = {});

}  // namespace boxunion
