#include "host/device/device.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "boxunion/error.hpp"
#include "host/device/backend.hpp"
#include "host/device/failing_device.hpp"
#include "host/device/forwarding_device.hpp"
#include "kernels/contract.h"

namespace boxunion {

Pages allocate_pages(std::size_t bytes) {
  void* memory = std::aligned_alloc(page_bytes, round_up(bytes, page_bytes));
  if (memory == nullptr) throw Error(ErrorKind::resources, fmt::format("cannot allocate {} bytes", bytes));
  return Pages(static_cast<std::byte*>(memory), &std::free);
}

void check_allocation(const DeviceInfo& info, std::size_t bytes) {
  if (bytes > info.max_buffer_bytes)
    throw Error(ErrorKind::resources,
                fmt::format("{}: a buffer of {} bytes is more than the {} that it allows", info.id, bytes,
                            info.max_buffer_bytes));
}

std::uint32_t most_work_items(const DeviceInfo& info, Shape shape) {
  // kernels reduce over at most so many lanes (SHARED_REDUCTION in the dialect)
  if (shape == Shape::group) return std::min(GROUP_LANES, info.max_workgroup);
  // a CPU runs the work-items of a group on one thread, whose stack holds the private memory of all
  return info.is_cpu ? std::min(64u, info.max_workgroup) : info.max_workgroup;
}

void check_workgroup(const DeviceInfo& info, Shape shape, std::uint32_t workgroup) {
  const std::uint32_t most = most_work_items(info, shape);
  if (workgroup == 0 || workgroup > most)
    throw Error(ErrorKind::device,
                fmt::format("{}: workgroups have 1 to {} work-items, not {}", info.id, most, workgroup));
}

void check_dispatch(const KernelSource& source, std::size_t buffers, std::size_t parameter_bytes,
                    std::uint32_t units) {
  if (buffers != source.buffers || parameter_bytes != source.parameter_bytes)
    throw Error(ErrorKind::device,
                fmt::format("kernel {} takes {} buffers and {} bytes of parameters, not {} and {}",
                            source.name, source.buffers, source.parameter_bytes, buffers, parameter_bytes));
  // the last workgroup may reach beyond the units, and its index must not wrap
  if (units > 0x7fffffffu)
    throw Error(ErrorKind::resources, fmt::format("kernel {}: {} units in one dispatch", source.name, units));
}

bool DriverProcess::claim() {
  int nobody = 0;
  return id_.compare_exchange_strong(nobody, ::getpid()) || nobody == ::getpid();
}

bool DriverProcess::is_here() const {
  return id_ == ::getpid();
}

std::string used_before_fork(std::string_view driver) {
  return fmt::format("{}: used before fork(), so that this process cannot use it", driver);
}

bool environment_flag(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != '\0' && std::string_view(value) != "0";
}

namespace {

/// A device of a driver. It fails in a child of the process that opened it.
class DriverDevice final : public ForwardingDevice {
 public:
  explicit DriverDevice(std::unique_ptr<Device> device) : ForwardingDevice(std::move(device)) {
    process_.claim();
  }

 private:
  void before(std::string_view) override {
    if (!process_.is_here()) throw Error(ErrorKind::device, used_before_fork(info().id));
  }

  DriverProcess process_;
};

/// False only if there certainly is no GPU. Drivers of CPU devices take 0.1 s to start, so the test pays off.
bool may_have_gpu() {
#ifdef __linux__
  for (const char* node : {"/dev/dri", "/dev/nvidiactl", "/dev/kfd", "/dev/dxg", "/dev/mali0"})
    if (std::filesystem::exists(node)) return true;
  return false;
#else
  return true;
#endif
}

[[noreturn]] void no_such_device(const std::string& id) {
  std::vector<std::string> notes;
  std::string message = fmt::format("no device '{}'; there are:", id);
  for (const DeviceInfo& device : list_devices(&notes)) message += " " + device.id;
  for (const std::string& note : notes) message += "; " + note;
  throw Error(ErrorKind::device, message);
}

/// The device of an id: its back end and its index there.
struct Place {
  const Backend* backend;
  std::size_t index;
};

/// The first GPU, if there is one.
std::optional<Place> first_gpu() {
  std::vector<std::string> notes;
  if (may_have_gpu())
    for (const Backend& backend : backends()) {
      const std::vector<DeviceInfo> devices = list_devices(backend, notes);
      for (std::size_t i = 0; i < devices.size(); ++i)
        if (!devices[i].is_cpu) return Place{&backend, i};
    }
  return std::nullopt;
}

/// Finds the device that an id means. Starts no driver without need.
Place resolve(const std::string& id) {
  const Backend& native = backends().front();
  if (id == native.kind) return {&native, 0};
  if (id == "auto") return first_gpu().value_or(Place{&native, 0});
  std::vector<std::string> notes;
  for (const Backend& backend : backends())
    if (id.starts_with(backend.kind)) {
      const std::vector<DeviceInfo> devices = list_devices(backend, notes);
      for (std::size_t i = 0; i < devices.size(); ++i)
        if (devices[i].id == id || devices[i].id == id + ":0") return {&backend, i};
    }
  no_such_device(id);
}

}  // namespace

std::vector<DeviceInfo> list_devices(std::vector<std::string>* notes) {
  std::vector<std::string> ignored;
  std::vector<DeviceInfo> devices;
  for (const Backend& backend : backends())
    for (DeviceInfo& device : list_devices(backend, notes != nullptr ? *notes : ignored))
      devices.push_back(std::move(device));
  return devices;
}

std::unique_ptr<Device> open_device(const std::string& id, ZeroCopy zero_copy) {
  const auto [backend, index] = resolve(id);
  std::unique_ptr<Device> device = backend->open(index, zero_copy);
  if (backend == &backends().front()) return device;
  return failing_if_asked(std::make_unique<DriverDevice>(std::move(device)));
}

std::unique_ptr<Device> open_device(const std::string& id) {
  return open_device(id, ZeroCopy::where_possible);
}

}  // namespace boxunion
