#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "host/device/device.hpp"

namespace boxunion {

/// Forwards to another device. Subclasses change parts of it.
class ForwardingDevice : public Device {
 public:
  explicit ForwardingDevice(std::unique_ptr<Device> device) : device_(std::move(device)) {}

  const DeviceInfo& info() const override { return device_->info(); }
  std::unique_ptr<Buffer> allocate(std::size_t bytes) override {
    before("allocate");
    return device_->allocate(bytes);
  }
  void upload(Buffer& buffer, std::size_t bytes) override {
    before("upload");
    device_->upload(buffer, bytes);
  }
  void download(Buffer& buffer, std::size_t offset, std::size_t bytes) override {
    before("download");
    device_->download(buffer, offset, bytes);
  }
  void clear(Buffer& buffer, std::size_t bytes) override {
    before("clear");
    device_->clear(buffer, bytes);
  }
  std::unique_ptr<Kernel> load(const KernelSource& source, Shape shape, std::uint32_t workgroup) override {
    before("load");
    return device_->load(source, shape, workgroup);
  }
  void dispatch(Kernel& kernel, std::span<Buffer* const> buffers, std::span<const std::byte> parameters,
                std::uint32_t units) override {
    before("dispatch");
    device_->dispatch(kernel, buffers, parameters, units);
  }
  void wait() override {
    before("wait");
    device_->wait();
  }
  double kernel_seconds() const override { return device_->kernel_seconds(); }

 private:
  /// Called at the start of every call that may fail, with the name of the call.
  virtual void before(std::string_view /*call*/) {}

  std::unique_ptr<Device> device_;
};

}  // namespace boxunion
