#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "host/device/backend.hpp"
#include "host/device/device.hpp"

namespace boxunion {

/// The devices of this machine. In a process for one test (ctest makes a process for each test), only the
/// native device and those of drivers that the test names, because drivers take longer to start than most
/// tests.
inline std::vector<DeviceInfo> devices_under_test() {
  constexpr std::string_view kFilter = "--gtest_filter=";
  std::ifstream arguments("/proc/self/cmdline");
  for (std::string argument; std::getline(arguments, argument, '\0');) {
    if (!argument.starts_with(kFilter) || argument.find_first_of("*?:-", kFilter.size()) != argument.npos)
      continue;
    std::vector<DeviceInfo> devices;
    std::vector<std::string> notes;
    for (const Backend& backend : backends())
      if (backend.kind == "native" || argument.find(backend.kind) != argument.npos)
        for (const DeviceInfo& device : list_devices(backend, notes)) devices.push_back(device);
    return devices;
  }
  return list_devices();
}

/// Tests that run once for every device of this machine: INSTANTIATE_TEST_SUITE_P(Devices, Suite,
/// testing::ValuesIn(device_ids()), device_name).
using EveryDevice = testing::TestWithParam<std::string>;

inline std::vector<std::string> device_ids() {
  std::vector<std::string> ids;
  for (const DeviceInfo& device : devices_under_test()) ids.push_back(device.id);
  return ids;
}

inline std::string device_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
}

}  // namespace boxunion
