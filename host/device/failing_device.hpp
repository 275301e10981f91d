#pragma once

#include <memory>

#include "host/device/device.hpp"

namespace boxunion {

/// Makes a device fail on purpose, so that tests and users can watch how a run handles it. Returns the device
/// unchanged unless BOXUNION_FAIL_DEVICE names a call and a number: "dispatch:3" makes the third dispatch
/// throw Error(device). The calls are allocate, upload, download, clear, load, dispatch and wait. Throws
/// Error(usage) if the variable has another form.
std::unique_ptr<Device> failing_if_asked(std::unique_ptr<Device> device);

}  // namespace boxunion
