#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "boxunion/error.hpp"
#include "boxunion/union.hpp"
#include "host/device/device.hpp"

namespace boxunion {

/// To be called in a handler of `error`. Warns and returns if the work may continue natively. Otherwise
/// rethrows the error, as Error(device) if a device failed.
inline void fall_back(const Error& error, const std::string& device, const Options& options) {
  const bool device_failed = error.kind() == ErrorKind::device || error.kind() == ErrorKind::resources;
  if (!device_failed || device == "native") throw;
  if (!options.fallback) throw Error(ErrorKind::device, device + " failed: " + error.what());
  if (options.warn) options.warn(device + " failed, continuing natively: " + error.what());
}

/// A stage of kernels on a device that may fail. After a failure it continues natively with a warning and the
/// same result, if the options allow that.
///
/// Stage is made from (Device&, const Tuning&) at first use and again after a failure.
template <class Stage>
class Resilient {
 public:
  explicit Resilient(const Options& options) : options_(options), device_(open_device(options.device)) {}

  const DeviceInfo& device() const { return device_->info(); }

  /// Calls f(stage). f may be called twice, so it must change nothing of its caller's until it is sure to
  /// succeed.
  template <class F>
  void run(F&& f) {
    try {
      f(stage());
    } catch (const Error& error) {
      fall_back(error, device_->info().id, options_);
      stage_.reset();
      device_ = open_device("native");
      f(stage());
    }
  }

 private:
  Stage& stage() {
    if (!stage_) stage_.emplace(*device_, options_.tuning);
    return *stage_;
  }

  const Options& options_;
  std::unique_ptr<Device> device_;
  std::optional<Stage> stage_;
};

}  // namespace boxunion
