#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>

#include "boxunion/device.hpp"
#include "host/device/device.hpp"
#include "host/files/output.hpp"

namespace boxunion {

/// "group", "item".
std::string_view to_string(Shape shape);

/// How a kernel shares its work on a device, and the number of work-items in a workgroup.
struct Launch {
  Shape shape = Shape::item;
  std::uint32_t workgroup = 1;
  friend bool operator==(const Launch&, const Launch&) = default;
};

/// The best launches, by device (its name and driver) and kernel. They never change a result.
class TunedLaunches {
 public:
  void set(const DeviceInfo& device, std::string_view kernel, Launch launch);
  std::optional<Launch> find(const DeviceInfo& device, std::string_view kernel) const;

  /// Reads a tuning file. A missing file has no launches. A file that cannot be read or is not a tuning file
  /// has none either, and invalid entries are left out; `warn` then gets a line for each.
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

/// Opens a tuning file for writing, before the work that fills it. Creates its folder if needed. Throws as
/// OutputFile does.
OutputFile open_tuning_file(const std::string& path, OutputGroup* group = nullptr);

/// The launch of a kernel: the one in `tuning`, otherwise the tuned one, otherwise what suits the device.
Launch choose_launch(const DeviceInfo& device, std::string_view kernel, const Tuning& tuning);

/// Loads a kernel for that launch.
std::unique_ptr<Kernel> load(Device& device, const KernelSource& source, const Tuning& tuning);

}  // namespace boxunion
