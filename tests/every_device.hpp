#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "host/device.hpp"

namespace boxunion {

/// The devices of this machine. In a process for one test that names no driver (ctest makes a process for
/// each test), only the native one: drivers take longer to start than most tests.
inline std::vector<DeviceInfo> devices_under_test() {
  constexpr std::string_view kFilter = "--gtest_filter=";
  std::ifstream arguments("/proc/self/cmdline");
  for (std::string argument; std::getline(arguments, argument, '\0');)
    if (argument.starts_with(kFilter) && argument.find_first_of("*?:-", kFilter.size()) == argument.npos &&
        argument.find("opencl") == argument.npos && argument.find("vulkan") == argument.npos)
      return {open_device("native")->info()};
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
