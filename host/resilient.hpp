#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/error.hpp"
#include "host/device.hpp"
#include "host/engine.hpp"

namespace boxunion {

/// A stage of kernels on a device that may fail: then it goes on natively, with a warning and the same
/// result.
///
/// Stage is made from (Device&, const Tuning&) at first use and again after a failure.
template <class Stage>
class Resilient {
 public:
  explicit Resilient(const Options& options) : options_(options), device_(open_device(options.device)) {}

  const DeviceInfo& device() const { return device_->info(); }

  /// Calls f(stage). f may be called twice, so it must not change anything of the caller's before it is sure
  /// to succeed.
  template <class F>
  void run(F&& f) {
    try {
      f(stage());
    } catch (const Error& error) {
      const bool device_failed = error.kind() == ErrorKind::device || error.kind() == ErrorKind::resources;
      if (!device_failed || device_->info().id == "native") throw;
      if (options_.warn) options_.warn(device_->info().id + " failed, going on natively: " + error.what());
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
