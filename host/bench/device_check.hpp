#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/device/device.hpp"
#include "host/tuning/tuning.hpp"

// A self-test: does every kernel give the right result on every device?

namespace boxunion {

/// How a kernel did on a device.
struct KernelCheck {
  std::string kernel;
  std::string failure{};      ///< what is wrong; empty if nothing is
  bool ran_natively = false;  ///< right, but in part only natively: the device cuts long loops short
};

/// How a device did.
struct DeviceCheck {
  DeviceInfo info;
  std::string failure{};  ///< why no kernel was tried, if none was
  std::vector<KernelCheck> kernels{};

  bool is_ok() const;
};

/// Runs every kernel on a device, on cells that the product itself cuts out of sparse, middle and dense
/// cubes, and compares all that it gives with the native device's results.
std::vector<KernelCheck> check_kernels(Device& device,
                                       const std::shared_ptr<const TunedLaunches>& tuned = {});

/// Computes small random unions and differences natively by every kernel, and compares them with a look at
/// every point of a grid.
std::vector<KernelCheck> check_native_kernels();

/// Checks all devices of this machine, native by check_native_kernels too; calls `done` after each. Takes
/// seconds, most of them for drivers that compile kernels. Throws Error(interrupted) soon after `interrupted`
/// becomes true.
std::vector<DeviceCheck> check_devices(const std::function<void(const DeviceCheck&)>& done,
                                       const std::shared_ptr<const TunedLaunches>& tuned = {},
                                       const std::atomic<bool>* interrupted = nullptr);

}  // namespace boxunion
