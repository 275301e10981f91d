#include <fmt/format.h>

#include "host/device/backend.hpp"

namespace boxunion {

// The functions in an entry of the table are in host/device/KIND_device.cpp.

std::vector<DeviceInfo> list_native(std::vector<std::string>& notes);
std::unique_ptr<Device> open_native(std::size_t index, ZeroCopy zero_copy);
std::vector<DeviceInfo> list_opencl(std::vector<std::string>& notes);
std::unique_ptr<Device> open_opencl(std::size_t index, ZeroCopy zero_copy);
std::vector<DeviceInfo> list_vulkan(std::vector<std::string>& notes);
std::unique_ptr<Device> open_vulkan(std::size_t index, ZeroCopy zero_copy);

namespace {

constexpr Backend kBackends[] = {
    {"native", "native", list_native, open_native},
#ifdef BOXUNION_HAVE_OPENCL
    {"opencl", "OpenCL", list_opencl, open_opencl},
#else
    {"opencl", "OpenCL"},
#endif
#ifdef BOXUNION_HAVE_VULKAN
    {"vulkan", "Vulkan", list_vulkan, open_vulkan},
#else
    {"vulkan", "Vulkan"},
#endif
};

}  // namespace

std::span<const Backend> backends() {
  return kBackends;
}

std::vector<DeviceInfo> list_devices(const Backend& backend, std::vector<std::string>& notes) {
  if (backend.list) return backend.list(notes);
  notes.push_back(fmt::format("{}: not built in", backend.name));
  return {};
}

std::string device_choices() {
  std::string ids = "auto, native";
  const auto drivers = backends().subspan(1);
  for (const Backend& backend : drivers)
    ids += fmt::format("{}{}[:i]", &backend == &drivers.back() ? " or " : ", ", backend.kind);
  return ids;
}

}  // namespace boxunion
