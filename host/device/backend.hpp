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

/// Whole pages, because device memory is not zero-copy if the host's copy shares a page with something else.
inline constexpr std::size_t page_bytes = 4096;
using Pages = std::unique_ptr<std::byte, decltype(&std::free)>;

/// At least `bytes` of host memory in whole pages. Throws Error(resources).
Pages allocate_pages(std::size_t bytes);

/// `bytes` rounded up to a multiple of words or pages; never 0, which devices cannot allocate.
constexpr std::size_t round_up(std::size_t bytes, std::size_t multiple) {
  return bytes == 0 ? multiple : (bytes + multiple - 1) / multiple * multiple;
}

/// Throws Error(resources) if a device cannot allocate so large a buffer.
void check_allocation(const DeviceInfo& info, std::size_t bytes);

/// The largest workgroup of a device for kernels of a shape.
std::uint32_t most_work_items(const DeviceInfo& info, Shape shape);

/// Throws Error(device) if a device cannot run so large a workgroup.
void check_workgroup(const DeviceInfo& info, Shape shape, std::uint32_t workgroup);

/// Throws Error(device) if the arguments of a dispatch do not fit the kernel.
void check_dispatch(const KernelSource& source, std::size_t buffers, std::size_t parameter_bytes,
                    std::uint32_t units);

/// The process that uses a driver: the first one that used it. The threads and locks of a driver do not
/// survive fork(), so a child that used the driver would wait forever.
class DriverProcess {
 public:
  /// Makes this process the owner, if the driver has none yet. False in a child of the owner.
  bool claim();
  /// False in a child of the owner, where not even handles can be released.
  bool is_here() const;

 private:
  std::atomic<int> id_ = 0;
};

/// The message for a driver that was used before fork().
std::string used_before_fork(std::string_view driver);

/// True if an environment variable is set to something other than "" or "0".
bool environment_flag(const char* name);

/// Whether buffers may be in memory that host and device share. `never` keeps a copy on each side, as a GPU
/// with its own memory needs it, so that tests cover that path without such a GPU.
enum class ZeroCopy { where_possible, never };

/// A kind of device: an entry of the table in host/device/backends.cpp.
struct Backend {
  std::string_view kind;  ///< the beginning of the ids of its devices
  std::string_view name;  ///< its name in messages
  /// Its devices in the order of their index, and notes on what is missing. Null if it is not built in.
  std::vector<DeviceInfo> (*list)(std::vector<std::string>& notes) = nullptr;
  /// Opens a device that list() has.
  std::unique_ptr<Device> (*open)(std::size_t index, ZeroCopy zero_copy) = nullptr;
};

/// The table, native first.
std::span<const Backend> backends();

/// The devices of a back end. One that is not built in has no devices, and adds a note.
std::vector<DeviceInfo> list_devices(const Backend& backend, std::vector<std::string>& notes);

/// The values of --device: "auto, native, opencl[:i] or vulkan[:i]".
std::string device_choices();

/// open_device with an option that only tests use.
std::unique_ptr<Device> open_device(const std::string& id, ZeroCopy zero_copy);

}  // namespace boxunion
