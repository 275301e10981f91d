#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/device/device.hpp"
#include "host/tuning/tuning.hpp"

// A self-test: checks whether every kernel gives the right result on every device.

namespace boxunion {

/// The result of checking a kernel on a device.
struct KernelCheck {
  std::string kernel;
  std::string failure{};      ///< description of the failure; empty if there is none
  bool ran_natively = false;  ///< right, but partly computed natively: the device cuts long loops short
};

/// The result of checking a device.
struct DeviceCheck {
  DeviceInfo info;
  std::string failure{};  ///< the reason if no kernel was tried
  std::vector<KernelCheck> kernels{};

  bool is_ok() const;
};

/// Runs every kernel on a device, on cells that the product itself cuts out of sparse, middle and dense
/// cubes, and compares the results with those of the native device.
std::vector<KernelCheck> check_kernels(Device& device,
                                       const std::shared_ptr<const TunedLaunches>& tuned = {});

/// Computes small random unions and differences natively with every kernel, and compares them with a test of
/// every point of a grid.
std::vector<KernelCheck> check_native_kernels();

/// Checks all devices of this machine, including native by check_native_kernels. Calls `done` after each.
/// Takes seconds, mostly for drivers that compile kernels. Interruptible.
std::vector<DeviceCheck> check_devices(const std::function<void(const DeviceCheck&)>& done,
                                       const std::shared_ptr<const TunedLaunches>& tuned = {});

}  // namespace boxunion
