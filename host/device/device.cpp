#include "host/device/device.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>
#include <string_view>
#include <utility>

#include "core/base/error.hpp"
#include "host/device/backend.hpp"
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
  // a CPU runs the work-items of a group on one thread, whose stack holds the private memory of all of them
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
  // the last workgroup may reach past the units, and its index must not wrap
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

#ifndef BOXUNION_HAVE_OPENCL
std::vector<DeviceInfo> list_opencl(std::vector<std::string>& notes) {
  notes.emplace_back("OpenCL: not built in");
  return {};
}
std::unique_ptr<Device> open_opencl(std::size_t, ZeroCopy) {
  return nullptr;
}
#endif

#ifndef BOXUNION_HAVE_VULKAN
std::vector<DeviceInfo> list_vulkan(std::vector<std::string>& notes) {
  notes.emplace_back("Vulkan: not built in");
  return {};
}
std::unique_ptr<Device> open_vulkan(std::size_t, ZeroCopy) {
  return nullptr;
}
#endif

namespace {

/// The call of a device that fails, and how many of them are left before it does; for tests.
struct InjectedFailure {
  std::string call;
  int countdown = 0;
};

/// A device of a driver. It fails in a child of the process that opened it, and where a test wants it to.
class DriverDevice final : public Device {
 public:
  DriverDevice(std::unique_ptr<Device> device, InjectedFailure failure)
      : device_(std::move(device)), failure_(std::move(failure)) {
    process_.claim();
  }

  const DeviceInfo& info() const override { return device_->info(); }
  std::unique_ptr<Buffer> allocate(std::size_t bytes) override {
    before("allocate");
    return device_->allocate(bytes);
  }
  void upload(Buffer& buffer, std::size_t bytes) override {
    before("upload");
    device_->upload(buffer, bytes);
  }
  void download(Buffer& buffer, std::size_t offset, std::size_t bytes) override {
    before("download");
    device_->download(buffer, offset, bytes);
  }
  void clear(Buffer& buffer, std::size_t bytes) override {
    before("clear");
    device_->clear(buffer, bytes);
  }
  std::unique_ptr<Kernel> load(const KernelSource& source, Shape shape, std::uint32_t workgroup) override {
    before("load");
    return device_->load(source, shape, workgroup);
  }
  void dispatch(Kernel& kernel, std::span<Buffer* const> buffers, std::span<const std::byte> parameters,
                std::uint32_t units) override {
    before("dispatch");
    device_->dispatch(kernel, buffers, parameters, units);
  }
  void wait() override {
    before("wait");
    device_->wait();
  }
  double kernel_seconds() const override { return device_->kernel_seconds(); }

 private:
  void before(std::string_view call) {
    if (!process_.is_here()) throw Error(ErrorKind::device, used_before_fork(info().id));
    if (call == failure_.call && --failure_.countdown == 0)
      throw Error(ErrorKind::device, fmt::format("{}: injected failure of {}", info().id, call));
  }

  std::unique_ptr<Device> device_;
  InjectedFailure failure_;
  DriverProcess process_;
};

InjectedFailure injected_failure() {
  const char* value = std::getenv("BOXUNION_FAIL_DEVICE");
  if (value == nullptr || *value == '\0') return {};
  const std::string_view text(value);
  const std::size_t colon = std::min(text.find(':'), text.size());
  const std::string_view call = text.substr(0, colon), number = text.substr(std::min(colon + 1, text.size()));
  int count = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), count);
  if (error != std::errc() || end != number.data() + number.size() || count < 1)
    throw Error(ErrorKind::usage, fmt::format("BOXUNION_FAIL_DEVICE={}: expected a call and a number from 1, "
                                              "for example dispatch:3",
                                              text));
  return {std::string(call), count};
}

/// False only where there certainly is no GPU. Drivers of CPU devices take 0.1 s to wake, so it is worth
/// asking.
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

/// The id of the device that `id` means. Wakes no driver without need.
std::string resolve(const std::string& id) {
  if (id == "native") return id;
  if (id == "auto") {
    if (may_have_gpu())
      for (const DeviceInfo& device : list_devices())
        if (!device.is_cpu) return device.id;
    return "native";
  }
  std::vector<std::string> notes;
  std::vector<DeviceInfo> devices;
  if (id.starts_with("opencl")) devices = list_opencl(notes);
  if (id.starts_with("vulkan")) devices = list_vulkan(notes);
  for (const DeviceInfo& device : devices)
    if (device.id == id || device.id == id + ":0") return device.id;
  no_such_device(id);
}

}  // namespace

std::vector<DeviceInfo> list_devices(std::vector<std::string>* notes) {
  std::vector<std::string> ignored;
  std::vector<std::string>& lines = notes != nullptr ? *notes : ignored;
  std::vector<DeviceInfo> devices{describe_native()};
  for (DeviceInfo& device : list_opencl(lines)) devices.push_back(std::move(device));
  for (DeviceInfo& device : list_vulkan(lines)) devices.push_back(std::move(device));
  return devices;
}

std::unique_ptr<Device> open_device(const std::string& id, ZeroCopy zero_copy) {
  const std::string found = resolve(id);
  if (found == "native") return open_native();
  const std::size_t colon = found.find(':');
  const std::size_t index = std::stoul(found.substr(colon + 1));
  return std::make_unique<DriverDevice>(
      found.starts_with("opencl") ? open_opencl(index, zero_copy) : open_vulkan(index, zero_copy),
      injected_failure());
}

std::unique_ptr<Device> open_device(const std::string& id) {
  return open_device(id, ZeroCopy::where_possible);
}

}  // namespace boxunion
