#pragma once

#include "host/device/device.hpp"
#include "host/device/forwarding_device.hpp"

namespace boxunion {

/// Forwards to the native device. Tests override parts of it.
class NativeProxy : public ForwardingDevice {
 public:
  NativeProxy() : ForwardingDevice(open_device("native")) {}
};

}  // namespace boxunion
