#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "host/device.hpp"

namespace boxunion {

/// Tests that run once for every device of this machine: INSTANTIATE_TEST_SUITE_P(Devices, Suite,
/// testing::ValuesIn(device_ids()), device_name).
using EveryDevice = testing::TestWithParam<std::string>;

inline std::vector<std::string> device_ids() {
  std::vector<std::string> ids;
  for (const DeviceInfo& device : list_devices()) ids.push_back(device.id);
  return ids;
}

inline std::string device_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
}

}  // namespace boxunion
