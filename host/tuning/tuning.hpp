#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>

#include "host/device/device.hpp"
#include "host/files/output.hpp"

namespace boxunion {

/// "group", "item".
std::string_view to_string(Shape shape);

/// How a kernel shares its work on a device, and in workgroups of how many work-items.
struct Launch {
  Shape shape = Shape::item;
  std::uint32_t workgroup = 1;
  friend bool operator==(const Launch&, const Launch&) = default;
};

/// Launches that proved best, by device (its name and driver) and kernel. They never change a result.
class TunedLaunches {
 public:
  void set(const DeviceInfo& device, std::string_view kernel, Launch launch);
  std::optional<Launch> find(const DeviceInfo& device, std::string_view kernel) const;

  /// Reads a tuning file. A file that is not there has no launches; one that cannot be read or is not a
  /// tuning file has none either, and entries that make no sense are left out: `warn` then gets a line for
  /// each.
  static TunedLaunches read(const std::string& path, const std::function<void(const std::string&)>& warn);
  /// Writes and commits a tuning file.
  void write(OutputFile file) const;

 private:
  struct Key {
    std::string device, driver, kernel;
    friend auto operator<=>(const Key&, const Key&) = default;
  };
  std::map<Key, Launch> launches_;
};

/// How kernels are launched; never changes a result. Zero or empty: what suits the device.
struct Tuning {
  std::optional<Shape> shape{};
  std::uint32_t workgroup = 0;
  std::uint32_t tile_coordinates = 0;  ///< slices: distinct coordinates an axis of a tile, at most 31
  std::uint32_t cell = 0;              ///< cells: edge in ordinals, rounded up to a power of two
  std::uint32_t cell_boxes = 0;        ///< cells: boxes above which a cell is cut again
  /// What proved best on some devices, for a shape and workgroup that are not given.
  std::shared_ptr<const TunedLaunches> tuned{};
};

/// Where this user's tuning file is: BOXUNION_TUNING, where that is set (empty: there is none), else
/// boxunion/tuning.json in $XDG_CONFIG_HOME or ~/.config. Empty if there is none.
std::string tuning_path();

/// Opens a tuning file to be written, in a folder that is made if need be, before the work that finds what it
/// will say. Throws as OutputFile does.
OutputFile open_tuning_file(const std::string& path, OutputGroup* group = nullptr);

/// The launch of a kernel: what `tuning` asks for, else what was tuned, else what suits the device.
Launch choose_launch(const DeviceInfo& device, std::string_view kernel, const Tuning& tuning);

/// Makes a kernel ready with that launch.
std::unique_ptr<Kernel> load(Device& device, const KernelSource& source, const Tuning& tuning);

}  // namespace boxunion
