#pragma once

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/device/device.hpp"

// What the back ends have in common and what host/device/device.cpp asks of them. Internal to host/.
namespace boxunion {

/// Device memory is not zero-copy if the host's copy shares a page with something else, hence pages.
inline constexpr std::size_t page_bytes = 4096;
using Pages = std::unique_ptr<std::byte, decltype(&std::free)>;

/// At least `bytes` of host memory in whole pages. Throws Error(resources).
Pages allocate_pages(std::size_t bytes);

/// `bytes` as a whole number of words or pages; never 0, which devices cannot allocate.
constexpr std::size_t round_up(std::size_t bytes, std::size_t multiple) {
  return bytes == 0 ? multiple : (bytes + multiple - 1) / multiple * multiple;
}

/// Throws Error(resources) if a device cannot allocate a buffer so large.
void check_allocation(const DeviceInfo& info, std::size_t bytes);

/// The largest workgroup of a device for kernels of a shape.
std::uint32_t most_work_items(const DeviceInfo& info, Shape shape);

/// Throws Error(device) if a device cannot run a workgroup so large.
void check_workgroup(const DeviceInfo& info, Shape shape, std::uint32_t workgroup);

/// Throws Error(device) if the arguments of a dispatch do not fit the kernel.
void check_dispatch(const KernelSource& source, std::size_t buffers, std::size_t parameter_bytes,
                    std::uint32_t units);

/// The process that a driver works for: the first one that used it. A driver's threads and locks do not
/// survive fork(), so that a child which used it would wait forever.
class DriverProcess {
 public:
  /// Makes this process the driver's, if none is yet; false in a child of the one that is.
  bool claim();
  /// False in a child of the process that used the driver: there, not even handles can be released.
  bool is_here() const;

 private:
  std::atomic<int> id_ = 0;
};

/// What is said where a driver was used before fork().
std::string used_before_fork(std::string_view driver);

/// Whether an environment variable is set to something other than "" or "0".
bool environment_flag(const char* name);

/// Whether buffers may live in memory that host and device share. `never` keeps a copy on each side as a GPU
/// of its own memory needs it, so that tests reach that path without such a GPU.
enum class ZeroCopy { where_possible, never };

/// A kind of device: one entry of the table in host/device/backends.cpp.
struct Backend {
  std::string_view kind;  ///< how the ids of its devices begin
  std::string_view name;  ///< what messages call it
  /// Its devices in the order of their index, and notes on what is missing. Null if it is not built in.
  std::vector<DeviceInfo> (*list)(std::vector<std::string>& notes) = nullptr;
  /// Opens a device that list() has.
  std::unique_ptr<Device> (*open)(std::size_t index, ZeroCopy zero_copy) = nullptr;
};

/// The table, native first.
std::span<const Backend> backends();

/// The devices of a back end. One that is not built in has none and notes that.
std::vector<DeviceInfo> list_devices(const Backend& backend, std::vector<std::string>& notes);

/// What --device takes: "auto, native, opencl[:i] or vulkan[:i]".
std::string device_choices();

/// open_device with a choice that only tests make.
std::unique_ptr<Device> open_device(const std::string& id, ZeroCopy zero_copy);

}  // namespace boxunion
